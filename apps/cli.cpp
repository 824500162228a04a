#include "afferent/apps/cli.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string_view>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/manual_command.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/scene/nearest_name.hpp"

namespace afferent {
namespace {

constexpr int interrupted_code = 130;  // as a shell reports Ctrl-C

// `name` is shown in the help. CLI11's own checks print the largest double with all of its 309 digits.
CLI::Validator sign_check(bool zero_too, const char* name) {
    return {[zero_too](const std::string& text) {
                double value = 0;
                if (!CLI::detail::lexical_cast(text, value)) return "must be a number, is " + text;
                const bool good = zero_too ? value >= 0 : value > 0;
                return good ? "" : std::string("must be ") + (zero_too ? ">=" : ">") + " 0, is " + text;
            },
            name, ""};
}

void add_to(CLI::App& app, const Option& option) {
    CLI::Option* added = std::visit(
        [&]<class T>(T* value) {
            if constexpr (std::is_same_v<T, bool>)
                return app.add_flag(option.name, *value, option.help);
            else
                return app.add_option(option.name, *value, option.help);
        },
        option.value);
    added->required(option.is_required);
    // One value each time that it is given: what follows may be a positional argument.
    if (std::holds_alternative<std::vector<std::string>*>(option.value) && option.name.starts_with("--"))
        added->allow_extra_args(false);
    if (option.shows_default) added->capture_default_str();
    if (option.sign == Option::Sign::not_negative) added->check(sign_check(true, "NONNEGATIVE"));
    if (option.sign == Option::Sign::positive) added->check(sign_check(false, "POSITIVE"));
    if (option.range) added->check(CLI::Range(option.range->first, option.range->second));
}

void fill(CLI::App& app, const Command& command) {
    for (const Option& option : command.options) add_to(app, option);
    for (const Option& option : command.options) {
        if (!option.excluded.empty()) app.get_option(option.name)->excludes(app.get_option(option.excluded));
        if (!option.needed.empty()) app.get_option(option.name)->needs(app.get_option(option.needed));
    }
    for (const Command& each : command.commands) fill(*app.add_subcommand(each.name, each.help), each);
    if (!command.commands.empty()) app.require_subcommand(1);
    app.footer(command.footer);
    if (command.run) app.callback(command.run);
}

std::string suggestion(const std::string& typed, const std::vector<std::string>& names) {
    const auto nearest = nearest_name(typed, names);
    return nearest ? "; did you mean " + *nearest + "?" : "";
}

// The message about an argument that is left over: it names no command, or no option of the command before
// it.
std::optional<std::string> unknown_name(const CLI::App& app, const Command& command,
                                        const std::string& path) {
    std::vector<std::string> options;
    std::vector<std::string> commands;
    for (const Option& option : command.options) options.push_back(option.name);
    for (const Command& each : command.commands) commands.push_back(each.name);
    for (const std::string& left : app.remaining()) {
        const std::string typed = left.substr(0, left.find('='));
        if (typed.starts_with("-"))
            return path + ": there is no option " + typed + suggestion(typed, options);
        if (!commands.empty()) return path + ": there is no command " + typed + suggestion(typed, commands);
    }
    for (const CLI::App* parsed : app.get_subcommands())
        for (const Command& each : command.commands)
            if (each.name == parsed->get_name())
                if (auto found = unknown_name(*parsed, each, path + " " + each.name)) return found;
    return std::nullopt;
}

// A terminal that is held, or a pipe that nobody reads, keeps no program from its end.
void tell(const std::string& failure, bool as_json) {
    const std::string line = as_json ? json(Summary{{"error", failure}}) : failure;
    print_within(STDERR_FILENO, line + '\n', std::chrono::seconds(1));
}

int parse_and_run(const Command& program, const std::string& version, int argc, char** argv, bool as_json) {
    CLI::App app{program.help, program.name};
    app.set_version_flag("--version", version);
    fill(app, program);
    try {
        app.parse(argc, argv);
        return EXIT_SUCCESS;
    } catch (const CLI::ParseError& error) {
        const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
        // A misspelt name is often reported as something required that is missing.
        if (code == CLI::ExitCodes::RequiredError || code == CLI::ExitCodes::ExtrasError) {
            if (const auto unknown = unknown_name(app, program, program.name)) {
                tell(*unknown + "\nRun with --help for more information.", as_json);
                return error.get_exit_code();
            }
        }
        std::ostringstream failure;
        app.exit(error, std::cout, failure);
        if (std::string text = failure.str(); !text.empty()) {
            text.erase(text.find_last_not_of('\n') + 1);
            tell(text, as_json);
        }
        return error.get_exit_code();
    }
}

int run_command_line(const Command& program, const std::string& version, int argc, char** argv,
                     bool as_json) {
    for (const Command& command : program.commands) {
        if (!command.rest || argc < 2 || command.name != argv[1]) continue;
        command.rest->assign(argv + 2, argv + argc);
        command.run();
        return EXIT_SUCCESS;
    }
    return parse_and_run(program, version, argc, argv, as_json);
}

}  // namespace

int run_program(Command program, const std::string& version, int argc, char** argv) {
    if (!program.commands.empty()) program.commands.push_back(manual_command(program, version));
    const bool as_json = std::find(argv, argv + argc, std::string_view("--json")) != argv + argc;
    try {
        const int code = run_command_line(program, version, argc, argv, as_json);
        // Output is lost if the disk is full or its reader has gone.
        if (std::fflush(stdout) == 0 && !std::ferror(stdout) && std::cout.flush()) return code;
        tell("standard output: cannot be written", as_json);
        return code == EXIT_SUCCESS ? EXIT_FAILURE : code;
    } catch (const Interrupted&) {
        return interrupted_code;
    } catch (const std::exception& error) {
        tell(error.what(), as_json);
        return EXIT_FAILURE;
    }
}

}  // namespace afferent
