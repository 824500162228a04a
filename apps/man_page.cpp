#include "afferent/apps/man_page.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>
#include <type_traits>

namespace afferent {
namespace {

// A hyphen that is typed is a minus for groff, and a line that begins with a dot would be a request.
std::string escaped(std::string_view text) {
    std::string safe;
    for (const char letter : text) {
        if (safe.empty() && (letter == '.' || letter == '\'')) safe += "\\&";
        if (letter == '\\')
            safe += "\\e";
        else if (letter == '-')
            safe += "\\-";
        else
            safe += letter;
    }
    return safe;
}

std::string bold(std::string_view text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string upper(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
    return text;
}

template <class T>
constexpr bool is_number = std::is_arithmetic_v<T> || std::is_same_v<T, std::optional<double>> ||
                           std::is_same_v<T, std::vector<std::uint32_t>>;

std::string capital(std::string text) {
    if (!text.empty())
        text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
    return text;
}

// For the list of all pages, where the name stands before it: without the name, and without a full stop.
std::string summary_of(const Command& command) {
    std::string help = command.help;
    if (help.starts_with(capital(command.name) + ": ")) help.erase(0, command.name.size() + 2);
    if (help.ends_with('.')) help.pop_back();
    return help;
}

// What follows the name on the command line.
const char* placeholder(const Option& option) {
    return std::visit([]<class T>(T*) { return is_number<T> ? "NUMBER" : "TEXT"; }, option.value);
}

std::string default_of(const Option& option) {
    return std::visit(
        []<class T>(const T* value) -> std::string {
            std::ostringstream text;
            if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) text << *value;
            return text.str();
        },
        option.value);
}

std::string limits(const Option& option) {
    std::ostringstream text;
    if (option.is_required) text << " Required.";
    if (option.sign == Option::Sign::not_negative) text << " At least 0.";
    if (option.sign == Option::Sign::positive) text << " More than 0.";
    if (option.range) text << " From " << option.range->first << " to " << option.range->second << '.';
    if (option.shows_default) text << " Default: " << default_of(option) << '.';
    if (!option.excluded.empty()) text << " Not with " << option.excluded << '.';
    return text.str();
}

std::string sentence(std::string text) {
    if (!text.empty() && !text.ends_with('.')) text += '.';
    return text;
}

void print_entry(std::ostream& page, const std::string& tag, const std::string& text) {
    page << ".TP\n" << tag << '\n' << escaped(text) << '\n';
}

void print_options(std::ostream& page, const Command& command, bool is_program) {
    bool any = false;
    for (const Option& option : command.options) {
        if (!option.is_positional()) continue;
        if (!std::exchange(any, true)) page << ".SH ARGUMENTS\n";
        print_entry(page, italic(option.name), sentence(option.help) + limits(option));
    }
    page << ".SH OPTIONS\n";
    print_entry(page, bold("-h") + ", " + bold("--help"), "Print a help message and exit.");
    if (is_program) print_entry(page, bold("--version"), "Print the version and exit.");
    for (const Option& option : command.options) {
        if (option.is_positional()) continue;
        const std::string value = option.is_flag() ? "" : " " + italic(placeholder(option));
        print_entry(page, bold(option.name) + value, sentence(option.help) + limits(option));
    }
}

void print_synopsis(std::ostream& page, const Command& command, const std::string& path) {
    page << ".SH SYNOPSIS\n" << bold(path) << " [" << italic("OPTION") << "]...";
    if (!command.commands.empty()) page << ' ' << italic("COMMAND") << " [" << italic("ARGUMENT") << "]...";
    for (const Option& option : command.options)
        if (option.is_positional()) page << ' ' << italic(option.name);
    page << '\n';
}

void print_commands(std::ostream& page, const Command& command, const std::string& path) {
    if (command.commands.empty()) return;
    page << ".SH COMMANDS\nEach has a page of its own, such as "
         << bold(joined(path + ' ' + command.commands.front().name, '-')) << "(1).\n";
    for (const Command& each : command.commands) print_entry(page, bold(each.name), sentence(each.help));
}

// The footer of a help is text with indented lines below headings: what stands under them is set as it is
// typed.
class Footer {
  public:
    explicit Footer(const std::string& footer) {
        std::istringstream in(footer);
        for (std::string line; std::getline(in, line);) lines_.push_back(line);
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            if (lines_[i].starts_with(' '))
                add_typed(lines_[i]);
            else
                begin(lines_[i], i + 1 < lines_.size() && lines_[i + 1].starts_with(' '));
        }
        end_typed();
    }

    friend std::ostream& operator<<(std::ostream& page, const Footer& footer) {
        const std::pair<const char*, const std::ostringstream&> sections[] = {
            {"NOTES", footer.notes_}, {"EXAMPLES", footer.examples_}, {"EXIT STATUS", footer.codes_}};
        for (const auto& [title, text] : sections)
            if (!text.view().empty()) page << ".SH " << title << '\n' << text.view();
        return page;
    }

  private:
    void begin(const std::string& line, bool is_heading) {
        end_typed();
        if (line.empty()) return void(*section_ << ".PP\n");
        if (!is_heading) return void(*(section_ = &notes_) << escaped(line) << '\n');
        section_ = line.starts_with("Exit codes") ? &codes_ : &examples_;
        // These headings say no more than the section's title does.
        if (line == "Example:" || line == "Examples:" || line == "Exit codes:") return;
        *section_ << escaped(line.starts_with("Example, ") ? capital(line.substr(9)) : line) << '\n';
    }
    void add_typed(const std::string& line) {
        if (!std::exchange(typed_, true)) *section_ << ".PP\n.RS 2\n.EX\n";
        *section_ << escaped(std::string_view(line).substr(2)) << '\n';
    }
    void end_typed() {
        if (std::exchange(typed_, false)) *section_ << ".EE\n.RE\n";
    }

    std::vector<std::string> lines_;
    std::ostringstream notes_;
    std::ostringstream examples_;
    std::ostringstream codes_;
    std::ostringstream* section_ = &notes_;
    bool typed_ = false;
};

void add_pages(std::vector<ManPage>& pages, const Command& command, const std::string& path,
               const std::string& above, const std::string& version) {
    const std::string name = joined(path, '-');
    std::ostringstream page;
    page << ".\\\" Written by `afferent manual`, from the program's own help.\n"
         << ".TH " << escaped(upper(name)) << " 1 \"\" \"Afferent " << escaped(version) << "\" \"Afferent\"\n"
         << ".SH NAME\n"
         << escaped(name) << " \\- " << escaped(summary_of(command)) << '\n';
    print_synopsis(page, command, path);
    print_commands(page, command, path);
    print_options(page, command, above.empty());
    page << Footer(command.footer) << ".SH SEE ALSO\n"
         << bold(above.empty() ? joined(path + ' ' + command.commands.front().name, '-') : joined(above, '-'))
         << "(1)\n";
    pages.push_back({name, page.str()});
    for (const Command& each : command.commands)
        if (!each.rest) add_pages(pages, each, path + ' ' + each.name, path, version);
}

}  // namespace

std::string joined(const std::string& path, char between) {
    std::string name = path;
    std::ranges::replace_if(
        name, [](char c) { return c == ' ' || c == '-'; }, between);
    return name;
}

std::vector<ManPage> man_pages(const Command& program, const std::string& version) {
    std::vector<ManPage> pages;
    add_pages(pages, program, program.name, "", version);
    return pages;
}

}  // namespace afferent
