#include "afferent/apps/manual_command.hpp"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <utility>

#include "afferent/apps/completions.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/man_page.hpp"
#include "afferent/apps/summary.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

struct ManualOptions {
    fs::path folder;
    bool json = false;
};

void write_file(const fs::path& file, const std::string& text) {
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    if (error) throw Failure(file.parent_path().string() + ": " + error.message());
    std::ofstream out(file, std::ios::binary);
    if (!(out << text << std::flush)) throw Failure(file.string() + ": cannot be written");
}

// The places below share/ where man and the shells look.
void write_manual(const ManualOptions& options, const Command& program, const std::string& version) {
    std::vector<std::pair<fs::path, std::string>> files;
    for (const ManPage& page : man_pages(program, version))
        files.emplace_back(fs::path("man") / "man1" / (page.name + ".1"), page.text);
    const std::string name = joined(program.name, '-');
    files.emplace_back(fs::path("bash-completion") / "completions" / name, bash_completion(program));
    files.emplace_back(fs::path("zsh") / "site-functions" / ("_" + name), zsh_completion(program));
    files.emplace_back(fs::path("fish") / "vendor_completions.d" / (name + ".fish"),
                       fish_completion(program));

    Summary written{{"folder", options.folder.string()}};
    for (const auto& [file, text] : files) {
        write_file(options.folder / file, text);
        written["files"].push_back(file.string());
    }
    if (options.json) return print(written, true);
    std::cout << files.size() << " files written to " << options.folder.string() << '\n';
}

}  // namespace

Command manual_command(const Command& program, std::string version) {
    const auto options = std::make_shared<ManualOptions>();
    return {
        .name = "manual",
        .help = "Write man pages, and completions for bash, zsh and fish",
        .footer =
            "The folder is laid out as share/ is: man, bash and fish find by themselves what is in "
            "~/.local/share.\n"
            "Example:\n  " +
            program.name + " manual ~/.local/share",
        .options = {positional("FOLDER", options->folder,
                               "Where to; what is there of an earlier version is replaced")
                        .required(),
                    flag("--json", options->json, "Print the names of the files as JSON")},
        .run = [options, &program,
                version = std::move(version)] { write_manual(*options, program, version); },
    };
}

}  // namespace afferent
