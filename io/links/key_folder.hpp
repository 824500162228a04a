// The files that `afferent keys` makes and a scene's `keys` names.
#pragma once

#include <filesystem>

#include "afferent/io/links/link_address.hpp"

namespace afferent {

enum class LinkSide { coprocessor, hand };

inline const char* name(LinkSide side) { return side == LinkSide::hand ? "hand" : "coprocessor"; }

// Each side needs the shared secret for UDP and serial lines, and for TLS both certificates and its own
// private key. It does not need the peer's private key.
struct KeyFolder {
    std::filesystem::path folder;

    std::filesystem::path secret() const { return folder / "link.key"; }
    std::filesystem::path certificate(LinkSide side) const {
        return folder / (std::string(name(side)) + ".crt");
    }
    std::filesystem::path private_key(LinkSide side) const {
        return folder / (std::string(name(side)) + ".key");
    }

    TlsCredentials credentials(LinkSide own) const {
        const LinkSide peer = own == LinkSide::hand ? LinkSide::coprocessor : LinkSide::hand;
        return {certificate(own), private_key(own), certificate(peer)};
    }
};

}  // namespace afferent
