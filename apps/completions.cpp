#include "afferent/apps/completions.hpp"

#include <functional>
#include <sstream>
#include <type_traits>

#include "afferent/apps/man_page.hpp"

namespace afferent {
namespace {

// A text may be the name of a file; of a number nothing can be proposed.
bool is_text(const Option& option) {
    return std::visit(
        []<class T>(T*) {
            return std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path> ||
                   std::is_same_v<T, std::vector<std::string>>;
        },
        option.value);
}

// As one word of a shell's command line; `inside` are the letters that mean something to whoever reads that
// word.
std::string quoted(const std::string& text, const std::string& inside = "") {
    std::string word = "'";
    for (const char letter : text) {
        if (inside.find(letter) != std::string::npos) word += '\\';
        if (letter == '\'')
            word += "'\\''";
        else
            word += letter;
    }
    return word + "'";
}

// The program and each command below it, with the words that lead there: "", "run", "link status".
void visit_all(const Command& command, const std::string& path,
               const std::function<void(const Command&, const std::string&)>& visit) {
    visit(command, path);
    for (const Command& each : command.commands)
        visit_all(each, path.empty() ? each.name : path + ' ' + each.name, visit);
}

std::string executable(const Command& program) { return joined(program.name, '-'); }
std::string function(const Command& program) { return "_" + joined(program.name, '_'); }
// A command that takes its arguments unparsed is a program with a completion of its own.
std::string sibling(const Command& program, const std::string& path) {
    return executable(program) + '-' + path;
}

void print_words(std::ostream& script, const char* name, const std::string& words) {
    if (!words.empty()) script << ' ' << name << "='" << words.substr(1) << "'";
}

void print_bash_case(std::ostream& script, const Command& program, const Command& command,
                     const std::string& path) {
    script << "    '" << path << "')";
    if (command.rest) {
        const std::string other = "_" + joined(sibling(program, path), '_');
        script << "\n        declare -F " << other << " >/dev/null || _completion_loader "
               << sibling(program, path) << " 2>/dev/null\n"
               << "        COMP_WORDS=(" << sibling(program, path) << " \"${COMP_WORDS[@]:2}\")\n"
               << "        COMP_CWORD=$((COMP_CWORD - 1))\n"
               << "        declare -F " << other << " >/dev/null && " << other << "\n        return ;;\n";
        return;
    }
    std::string commands;
    std::string numbers;
    std::string texts;
    std::string options = path.empty() ? " --help --version" : " --help";
    for (const Command& each : command.commands) commands += ' ' + each.name;
    for (const Option& option : command.options) {
        if (option.is_positional()) continue;
        options += ' ' + option.name;
        if (!option.is_flag()) (is_text(option) ? texts : numbers) += ' ' + option.name;
    }
    print_words(script, "commands", commands);
    print_words(script, "options", options);
    print_words(script, "numbers", numbers);
    print_words(script, "texts", texts);
    script << " ;;\n";
}

std::string zsh_spec(const Option& option, int& position) {
    if (option.is_positional())
        return quoted(std::to_string(++position) + ":") + quoted(option.name, ":") + ":_files";
    std::string spec;
    if (!option.excluded.empty()) spec += quoted("(" + option.excluded + ")");
    if (option.is_flag()) return spec + option.name + quoted("[") + quoted(option.help, "[]:") + quoted("]");
    return spec + option.name + "=" + quoted("[") + quoted(option.help, "[]:") + quoted("]") +
           (is_text(option) ? quoted(":file:_files") : quoted(":number: "));
}

void print_zsh_function(std::ostream& script, const Command& program, const Command& command,
                        const std::string& path) {
    script << function(program) << (path.empty() ? "" : "_") << joined(path, '_') << "() {\n";
    if (command.rest) {
        script << "    words[1]=" << sibling(program, path) << "\n    _normal\n}\n\n";
        return;
    }
    if (!command.commands.empty()) script << "    local line state context\n    typeset -A opt_args\n";
    script << "    _arguments " << (command.commands.empty() ? "-S" : "-C") << " \\\n"
           << "        '(- *)'{-h,--help}'[Print a help message and exit]'";
    if (path.empty()) script << " \\\n        '(- *)--version[Print the version and exit]'";
    int position = 0;
    for (const Option& option : command.options) script << " \\\n        " << zsh_spec(option, position);
    if (command.commands.empty()) {
        script << "\n}\n\n";
        return;
    }
    script
        << " \\\n        '1:command:->command' '*::argument:->argument'\n    case $state in\n    command)\n"
        << "        local -a commands=(\n";
    for (const Command& each : command.commands)
        script << "            " << quoted(each.name + ":") << quoted(each.help) << '\n';
    script << "        )\n        _describe command commands ;;\n    argument)\n        case $words[1] in\n";
    for (const Command& each : command.commands)
        script << "        " << each.name << ") " << function(program) << (path.empty() ? "" : "_")
               << joined(path, '_') << '_' << each.name << " ;;\n";
    script << "        esac ;;\n    esac\n}\n\n";
}

// fish reads \\ and \' inside single quotes.
std::string fish_quoted(const std::string& text) {
    std::string word = "'";
    for (const char letter : text) {
        if (letter == '\'' || letter == '\\') word += '\\';
        word += letter;
    }
    return word + "'";
}

void print_fish_lines(std::ostream& script, const Command& program, const Command& command,
                      const std::string& path) {
    const std::string begin = "complete -c " + executable(program) + " -n '_" + function(program);
    const std::string here = begin + "_is " + path + "' ";
    const std::string below = begin + "_below " + path + "' ";
    if (command.rest) {
        script << below << "-f -a '(complete -C (string join \" \" -- " << sibling(program, path)
               << " (commandline -opc)[3..-1] (commandline -ct)))'\n";
        return;
    }
    for (const Command& each : command.commands)
        script << here << "-f -a " << each.name << " -d " << fish_quoted(each.help) << '\n';
    script << below << "-s h -l help -d 'Print a help message and exit'\n";
    if (path.empty()) script << here << "-l version -d 'Print the version and exit'\n";
    for (const Option& option : command.options) {
        if (option.is_positional()) continue;
        script << below << "-l " << option.name.substr(2)
               << (option.is_flag()  ? ""
                   : is_text(option) ? " -r"
                                     : " -x")
               << " -d " << fish_quoted(option.help) << '\n';
    }
}

}  // namespace

std::string bash_completion(const Command& program) {
    std::ostringstream script;
    std::string paths;
    visit_all(program, "", [&](const Command&, const std::string& path) {
        if (!path.empty()) paths += (paths.empty() ? "'" : " | '") + path + "'";
    });
    script << "# bash completion for " << executable(program) << ", written by `afferent manual`.\n"
           << function(program) << R"(() {
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local path='' word commands='' options='' numbers='' texts=''
    for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
        case "${path:+$path }$word" in
        )" << paths
           << R"() path="${path:+$path }$word" ;;
        esac
    done
    case $path in
)";
    visit_all(program, "", [&](const Command& command, const std::string& path) {
        print_bash_case(script, program, command, path);
    });
    script << R"(    esac
    COMPREPLY=()
    # The shell splits --out=folder into three words.
    if [[ $previous == = ]]; then previous=${COMP_WORDS[COMP_CWORD - 2]}; fi
    if [[ $current == = ]]; then previous=${COMP_WORDS[COMP_CWORD - 1]} current=; fi
    if [[ -n $numbers && " $numbers " == *" $previous "* ]]; then
        return
    elif [[ $current == -* && " $texts " != *" $previous "* ]]; then
        COMPREPLY=($(compgen -W "$options" -- "$current"))
    elif [[ -n $commands ]]; then
        COMPREPLY=($(compgen -W "$commands" -- "$current"))
    else
        local IFS=$'\n'
        compopt -o filenames 2>/dev/null
        COMPREPLY=($(compgen -f -- "$current"))
    fi
}
complete -F )"
           << function(program) << ' ' << executable(program) << '\n';
    return script.str();
}

std::string zsh_completion(const Command& program) {
    std::ostringstream script;
    script << "#compdef " << executable(program) << "\n# Written by `afferent manual`.\n\n";
    visit_all(program, "", [&](const Command& command, const std::string& path) {
        print_zsh_function(script, program, command, path);
    });
    script << function(program) << " \"$@\"\n";
    return script.str();
}

std::string fish_completion(const Command& program) {
    std::ostringstream script;
    const std::string name = "_" + function(program);
    script << "# fish completion for " << executable(program) << ", written by `afferent manual`.\n"
           << "function " << name
           << "_is\n    set -l words (commandline -opc)\n    test \"$words[2..-1]\" = \"$argv\"\nend\n"
           << "function " << name << "_below\n    set -l words (commandline -opc)[2..-1]\n"
           << "    set -l depth (count $argv)\n    test $depth -eq 0; or test \"$words[1..$depth]\" = "
              "\"$argv\"\nend\n";
    visit_all(program, "", [&](const Command& command, const std::string& path) {
        print_fish_lines(script, program, command, path);
    });
    return script.str();
}

}  // namespace afferent
