#include "afferent/io/pictures/gnuplot.hpp"

#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

extern char** environ;

namespace afferent {
namespace {

struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

Drawing failed(std::string message) { return {Drawn::failed, std::move(message)}; }
std::string system_message(int code) { return std::generic_category().message(code); }

// What was written to a file, from its beginning; no more than fits a message.
std::string said(std::FILE* file) {
    std::array<char, 2000> text;
    std::rewind(file);
    std::string_view words(text.data(), std::fread(text.data(), 1, text.size(), file));
    const auto first = words.find_first_not_of(" \n");
    const auto last = words.find_last_not_of(" \n");
    return first == std::string_view::npos ? "" : std::string(words.substr(first, last - first + 1));
}

}  // namespace

Drawing run_gnuplot(std::string_view script) {
    // Files without a name, and not pipes: neither side can block on the other, and a gnuplot that dies early
    // sends no SIGPIPE.
    const File input(std::tmpfile());
    const File output(std::tmpfile());
    if (!input || !output) return failed("no temporary file: " + system_message(errno));
    if (std::fwrite(script.data(), 1, script.size(), input.get()) != script.size() ||
        std::fflush(input.get()) != 0)
        return failed("no room for a temporary file: " + system_message(errno));
    std::rewind(input.get());

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, fileno(input.get()), 0);
    posix_spawn_file_actions_adddup2(&files, fileno(output.get()), 1);
    posix_spawn_file_actions_adddup2(&files, fileno(output.get()), 2);
    // gnuplot inherits no other descriptor: if it hung, a peer would take a socket that it holds open for
    // this process.
    posix_spawn_file_actions_addclosefrom_np(&files, 3);
    std::string name = "gnuplot";
    std::string own_settings = "--default-settings";
    std::array<char*, 3> arguments{name.data(), own_settings.data(), nullptr};
    pid_t process = 0;
    const int refused = posix_spawnp(&process, name.c_str(), &files, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (refused == ENOENT) return {Drawn::no_gnuplot, "gnuplot is not installed"};
    if (refused != 0) return failed("gnuplot cannot be started: " + system_message(refused));

    int status = 0;
    while (waitpid(process, &status, 0) < 0)
        if (errno != EINTR) return failed("gnuplot was lost: " + system_message(errno));
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {Drawn::done, {}};
    return failed(said(output.get()));
}

}  // namespace afferent
