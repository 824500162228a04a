// afferent keys: makes the keys and certificates by which the two ends of a link authenticate each other.
#include <filesystem>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/io/links/certificate.hpp"
#include "afferent/io/links/key_folder.hpp"
#include "afferent/io/links/secret_key.hpp"

namespace afferent {
namespace {

void make_keys(const KeyFolder& keys) {
    std::error_code error;
    std::filesystem::create_directories(keys.folder, error);
    if (error) throw Failure(keys.folder.string() + ": " + error.message());
    value_or_fail(SecretKey::generate().write(keys.secret()));
    for (const LinkSide side : {LinkSide::coprocessor, LinkSide::hand})
        value_or_fail(write_certificate(std::string("Afferent ") + name(side), keys.certificate(side),
                                        keys.private_key(side)));
    const auto list = [&](LinkSide side) {
        std::cout << "  for the " << name(side) << ":";
        for (const auto& file : {keys.secret(), keys.certificate(LinkSide::coprocessor),
                                 keys.certificate(LinkSide::hand), keys.private_key(side)})
            std::cout << ' ' << file.filename().string();
        std::cout << '\n';
    };
    std::cout << "written to " << keys.folder.string() << '\n';
    list(LinkSide::coprocessor);
    list(LinkSide::hand);
    std::cout << "Where the two run on two machines, copy these files alone, over a way that nobody reads.\n";
}

}  // namespace

Command keys_command() {
    const auto keys = std::make_shared<KeyFolder>();
    return {
        .name = "keys",
        .help =
            "Make the keys and certificates of one coprocessor and one hand, for links that leave the "
            "machine",
        .footer =
            "A scene names the folder: link { keys: \"keys\" tcp { host: \"192.0.2.7\" } }\n"
            "Example:\n  afferent keys keys",
        .options = {positional("FOLDER", keys->folder, "Where to; nothing there is written over").required()},
        .run = [keys] { make_keys(*keys); },
    };
}

}  // namespace afferent
