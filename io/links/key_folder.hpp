// The files that `afferent keys` makes and a scene's `keys` names.
#pragma once

#include <filesystem>
#include <string>

#include "afferent/io/links/tls.hpp"

namespace afferent {

enum class LinkEnd { coprocessor, hand };

inline const char* name(LinkEnd link_end) { return link_end == LinkEnd::hand ? "hand" : "coprocessor"; }

// Each end needs both certificates and its own private key, whatever the transport. It does not need the
// peer's private key, and cannot stand in for the peer.
struct KeyFolder {
    std::filesystem::path folder;

    std::filesystem::path certificate(LinkEnd link_end) const {
        return folder / (std::string(name(link_end)) + ".crt");
    }
    std::filesystem::path private_key(LinkEnd link_end) const {
        return folder / (std::string(name(link_end)) + ".key");
    }

    TlsCredentials credentials(LinkEnd own) const {
        const LinkEnd peer = own == LinkEnd::hand ? LinkEnd::coprocessor : LinkEnd::hand;
        return {certificate(own), private_key(own), certificate(peer)};
    }
};

}  // namespace afferent
