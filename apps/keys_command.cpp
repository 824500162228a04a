// afferent keys: makes the keys and certificates by which the two ends of a link authenticate each other.
#include <filesystem>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/links/certificate.hpp"
#include "afferent/io/links/key_folder.hpp"

namespace afferent {
namespace {

struct KeysOptions {
    KeyFolder keys;
    bool json = false;
};

void make_keys(const KeysOptions& options) {
    const KeyFolder& keys = options.keys;
    std::error_code error;
    std::filesystem::create_directories(keys.folder, error);
    if (error) throw Failure(keys.folder.string() + ": " + error.message());
    for (const LinkEnd link_end : {LinkEnd::coprocessor, LinkEnd::hand})
        value_or_fail(write_certificate(std::string("Afferent ") + name(link_end), keys.certificate(link_end),
                                        keys.private_key(link_end)));
    Summary made{{"folder", keys.folder.string()}};
    for (const LinkEnd link_end : {LinkEnd::coprocessor, LinkEnd::hand})
        for (const auto& file : {keys.certificate(LinkEnd::coprocessor), keys.certificate(LinkEnd::hand),
                                 keys.private_key(link_end)})
            made[name(link_end)].push_back(file.filename().string());
    if (options.json) return print(made, true);
    std::cout << "written to " << keys.folder.string() << '\n';
    for (const LinkEnd link_end : {LinkEnd::coprocessor, LinkEnd::hand}) {
        std::cout << "  for the " << name(link_end) << ":";
        for (const Summary& file : made[name(link_end)].list()) std::cout << ' ' << *file.text();
        std::cout << '\n';
    }
    std::cout << "Where the two run on two machines, copy these files alone, over a way that nobody reads.\n";
}

}  // namespace

Command keys_command() {
    const auto options = std::make_shared<KeysOptions>();
    return {
        .name = "keys",
        .help =
            "Make the keys and certificates of one coprocessor and one hand, for links that leave the "
            "machine",
        .footer =
            "A scene names the folder: link { keys: \"keys\" tcp { host: \"192.0.2.7\" } }\n"
            "Example:\n  afferent keys keys",
        .options =
            {positional("FOLDER", options->keys.folder, "Where to; nothing there is written over").required(),
             flag("--json", options->json, "Print the names of the files as JSON")},
        .run = [options] { make_keys(*options); },
    };
}

}  // namespace afferent
