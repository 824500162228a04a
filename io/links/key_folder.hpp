// The files that `afferent keys` makes and a scene's `keys` names.
#pragma once

#include <filesystem>
#include <string>

#include "afferent/io/links/tls.hpp"

namespace afferent {

enum class LinkSide { coprocessor, hand };

inline const char* name(LinkSide side) { return side == LinkSide::hand ? "hand" : "coprocessor"; }

// Each side needs both certificates and its own private key, whatever the transport. It does not need the
// peer's private key, and cannot stand in for the peer.
struct KeyFolder {
    std::filesystem::path folder;

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
