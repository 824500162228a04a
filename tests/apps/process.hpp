// Runs the program as a user would.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace afferent {

inline const std::string examples = AFFERENT_SOURCE_DIR "/examples/";

// Fields of a link: a busy machine may hold a process up for longer than the default thresholds allow.
inline const std::string patient = "freeze_ms: 300 safe_ms: 4000 stale_ms: 1500";
// The same where the test waits for the safe state.
inline const std::string less_patient = "freeze_ms: 300 safe_ms: 1200 stale_ms: 1000";

inline std::string read_file(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline std::filesystem::path write_file(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
    return file;
}

// Waits for it; a minute is longer than a busy machine takes for anything.
template <class Condition>
bool comes_true(Condition condition) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > limit) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

// Whether a command that writes its results into the folder has begun to: it can be interrupted by then.
inline bool has_begun_in(const std::filesystem::path& folder) {
    if (!std::filesystem::is_directory(folder)) return false;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_directory() && entry.path().filename().string().starts_with("unfinished-")) return true;
    return false;
}

// The one that was built with the tests, or another that is to give the same, as for another machine.
inline std::string tested_program() {
    const char* const other = std::getenv("AFFERENT_PROGRAM");
    return other ? other : AFFERENT_PROGRAM;
}

class Process {
  public:
    explicit Process(std::vector<std::string> arguments, const std::string& input = "",
                     const std::string& program = tested_program()) {
        write_file(folder_ / "in", input);
        arguments.insert(arguments.begin(), program);
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        // Where the test has another thread, nothing may be allocated between fork and exec.
        const std::string reads = folder_("in");
        const std::string writes = folder_("out");
        const std::string reports = folder_("err");
        pid_ = ::fork();
        if (pid_ != 0) return;
        ::dup2(::open(reads.c_str(), O_RDONLY), STDIN_FILENO);
        ::dup2(::open(writes.c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
        ::dup2(::open(reports.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
        ::execv(argv[0], argv.data());
        ::_exit(127);
    }
    ~Process() {
        if (pid_ > 0) {
            ::kill(pid_, SIGKILL);
            wait();
        }
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void signal(int number) { ::kill(pid_, number); }
    pid_t id() const { return pid_; }

    // The exit code; minus the number of the signal that ended it. A process that hangs is killed in the end.
    int wait() {
        for (int i = 0; pid_ != 0 && ::waitpid(pid_, &status_, WNOHANG) == 0; ++i) {
            if (i == longest_life_ms) ::kill(pid_, SIGKILL);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        pid_ = 0;
        return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
    }

    // Waits until it has said so on standard error.
    bool has_said(const std::string& text) {
        return comes_true([&] { return err().find(text) != std::string::npos; });
    }

    std::string out() const { return read_file(folder_ / "out"); }
    std::string err() const { return read_file(folder_ / "err"); }

  private:
    static constexpr int longest_life_ms = 240'000;

    Folder folder_;
    pid_t pid_ = 0;  // 0: it has ended
    int status_ = 0;
};

// The status of a scene is asked for by its fingerprint, in which a seed makes a difference.
inline std::string seed_of_its_own() { return "seed: " + std::to_string(::getpid()) + " "; }

// Waits until the scene's hand operates: one that does not is safe already, and does not become so.
inline bool comes_to_operate(const std::string& scene) {
    return comes_true([&] {
        Process status({"link", "status", scene, "--json"});
        status.wait();
        return status.out().find("\"operating\"") != std::string::npos;
    });
}

}  // namespace afferent
