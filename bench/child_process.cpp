#include "bench/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace afferent::bench {
namespace {

using Clock = std::chrono::steady_clock;

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// The environment of this process, with another folder for the sockets of the user.
std::vector<std::string> environment(const std::filesystem::path& runtime) {
    const std::string name = "XDG_RUNTIME_DIR=";
    std::vector<std::string> variables{name + runtime.string()};
    for (char** variable = environ; *variable != nullptr; ++variable)
        if (std::string(*variable).rfind(name, 0) != 0) variables.emplace_back(*variable);
    return variables;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
    std::vector<char*> found;
    for (std::string& text : texts) found.push_back(text.data());
    found.push_back(nullptr);
    return found;
}

}  // namespace

ChildProcess::ChildProcess(const std::filesystem::path& folder, const std::string& name,
                           std::vector<std::string> command)
    : out_(folder / (name + ".out")), err_(folder / (name + ".err")) {
    constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_.c_str(), flags, 0600);
    ::posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_.c_str(), flags, 0600);
    std::vector<std::string> variables = environment(folder);
    const int error = ::posix_spawn(&pid_, command[0].c_str(), &files, nullptr, pointers(command).data(),
                                    pointers(variables).data());
    ::posix_spawn_file_actions_destroy(&files);
    if (error != 0) throw std::runtime_error(command[0] + ": " + std::strerror(error));
}

ChildProcess::~ChildProcess() {
    if (pid_ == 0) return;
    signal(SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

void ChildProcess::signal(int number) const {
    if (pid_ != 0) ::kill(pid_, number);
}

std::optional<int> ChildProcess::wait(std::chrono::milliseconds most) {
    const auto end = Clock::now() + most;
    int status = 0;
    while (::waitpid(pid_, &status, WNOHANG) == 0) {
        if (Clock::now() > end) return std::nullopt;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

bool ChildProcess::says(const std::string& text, std::chrono::milliseconds most) const {
    const auto end = Clock::now() + most;
    while (err().find(text) == std::string::npos) {
        if (Clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
}

std::string ChildProcess::out() const { return read(out_); }
std::string ChildProcess::err() const { return read(err_); }

std::optional<double> ChildProcess::peak_rss_mb() const {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    for (std::string word; status >> word;)
        if (double kb = 0; word == "VmHWM:" && status >> kb) return kb / 1024;
    return std::nullopt;
}

}  // namespace afferent::bench
