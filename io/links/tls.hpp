// Links over TLS 1.3, each end known to the other by its certificate.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

class Connector;
class Listener;
struct LinkOptions;
struct Patience;

// PEM files: what we show, how we prove that it is ours, and the one certificate that we accept.
struct TlsCredentials {
    std::filesystem::path certificate;
    std::filesystem::path private_key;
    std::filesystem::path peer_certificate;
};

struct TlsAddress {
    std::string host;
    std::uint16_t port;
    TlsCredentials credentials;

    std::string text() const;
};

// `not_allowed` where a file of the credentials cannot be read or does not fit the others, or a private key
// is open to others than its owner. A peer whose certificate is another than the one that we hold is turned
// away, and counted; so is one that speaks an older version, or none.
Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const TlsAddress& address,
                                            const LinkOptions& options);

std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const TlsAddress& address,
                                        const Patience& patience, const LinkOptions& options);

}  // namespace afferent
