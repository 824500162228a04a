// afferent bench: starts the benchmarks, which are a program of their own.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/sibling_program.hpp"

namespace afferent {
namespace {

// Replaces this process by afferent-bench with these arguments. Throws Failure where that cannot be started.
[[noreturn]] void become_benchmarks(std::vector<std::string> arguments) {
    std::string name = "afferent-bench";
    std::vector<char*> argv{name.data()};
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string program = sibling_program(name).string();
    ::execvp(program.c_str(), argv.data());
    if (errno != ENOENT) throw Failure(program + ": " + std::strerror(errno));
    throw Failure("the benchmarks are a program of their own, " + name +
                  ", which is neither beside this one nor in PATH. Build it: scripts/build.sh release " +
                  name);
}

}  // namespace

Command bench_command() {
    const auto arguments = std::make_shared<std::vector<std::string>>();
    return {
        .name = "bench",
        .help = "Measure, and check what is measured",
        .rest = arguments.get(),
        .run = [arguments] { become_benchmarks(*arguments); },
    };
}

}  // namespace afferent
