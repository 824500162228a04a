// A program that runs beside a benchmark; what it says is kept in files.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace afferent::bench {

class ChildProcess {
  public:
    // Its standard output and error go to <name>.out and <name>.err in the folder, which is its
    // XDG_RUNTIME_DIR as well. Throws std::runtime_error where it cannot be started.
    ChildProcess(const std::filesystem::path& folder, const std::string& name,
                 std::vector<std::string> command);
    // Kills it.
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    void signal(int number) const;
    // Its exit code, or minus the number of the signal that ended it; nothing if it goes on for longer.
    std::optional<int> wait(std::chrono::milliseconds most);
    // Whether standard error has come to hold the text in time.
    bool says(const std::string& text, std::chrono::milliseconds most) const;

    std::string out() const;
    std::string err() const;
    // The most memory that it has held so far; nothing once it has ended.
    std::optional<double> peak_rss_mb() const;

  private:
    std::filesystem::path out_;
    std::filesystem::path err_;
    pid_t pid_ = 0;
};

}  // namespace afferent::bench
