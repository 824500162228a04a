// What a command of a program is: its name, its options bound to variables, its help, and what it runs. Only
// cli.cpp knows the library that parses arguments.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace afferent {

struct Option {
    using Value = std::variant<bool*, double*, std::optional<double>*, std::int64_t*, std::uint64_t*,
                               std::optional<std::uint64_t>*, std::string*, std::filesystem::path*,
                               std::vector<std::string>*, std::vector<std::uint32_t>*>;
    enum class Sign { any, not_negative, positive };

    std::string name;  // "--out"; "SCENE" where it is known by its position
    Value value;       // owned by the command's run()
    std::string help;

    bool is_required = false;
    bool shows_default = false;
    Sign sign = Sign::any;
    std::optional<std::pair<double, double>> range = {};  // both ends allowed
    std::string excluded = {};                            // the option that cannot be given with this one
    std::string needed = {};                              // the option without which this one cannot be given

    bool is_positional() const { return !name.starts_with("-"); }
    bool is_flag() const { return std::holds_alternative<bool*>(value); }

    Option& required() { return is_required = true, *this; }
    // Shows in the help what the variable holds before it is set.
    Option& show_default() { return shows_default = true, *this; }
    Option& not_negative() { return sign = Sign::not_negative, *this; }
    Option& positive() { return sign = Sign::positive, *this; }
    Option& within(double least, double most) { return range.emplace(least, most), *this; }
    Option& excludes(std::string other) { return excluded = std::move(other), *this; }
    Option& needs(std::string other) { return needed = std::move(other), *this; }
};

template <class T>
Option option(std::string name, T& value, std::string help) {
    return {.name = std::move(name), .value = &value, .help = std::move(help)};
}
template <class T>
Option positional(std::string name, T& value, std::string help) {
    return option(std::move(name), value, std::move(help));
}
inline Option flag(std::string name, bool& value, std::string help) {
    return option(std::move(name), value, std::move(help));
}

struct Command {
    std::string name;
    std::string help;
    std::string footer = {};  // below the options: an example
    std::vector<Option> options = {};
    std::vector<Command> commands = {};        // where there are any, one has to be named
    std::vector<std::string>* rest = nullptr;  // takes all that follows the name, --help included, unparsed
    std::function<void()> run = {};
};

// The exit codes of a program, for the help. A wrong command line has the codes of the library that parses
// it.
inline constexpr const char* exit_codes =
    "Exit codes:\n"
    "  0           done\n"
    "  1           failed, or a session broke off or was interrupted before the scene's end:\n"
    "              standard error says why, under --json as {\"error\": ...}\n"
    "  100 to 127  the command line is wrong: nothing was run\n"
    "  130         interrupted by Ctrl-C, SIGTERM or SIGHUP, with all results so far written";

// Runs the command that the arguments name and returns the exit code of the process. Prints errors. A program
// with commands gets one more: manual.
int run_program(Command program, const std::string& version, int argc, char** argv);

}  // namespace afferent
