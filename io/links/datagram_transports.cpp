#include "afferent/io/links/datagram_transports.hpp"

#include <algorithm>
#include <utility>

#include "afferent/io/links/datagram_connector.hpp"
#include "afferent/io/links/datagram_listener.hpp"
#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/serial_port.hpp"
#include "afferent/io/links/udp_port.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;

// Datagrams that wait long for a serial line are too old: the queue holds a tenth of a second.
LinkOptions for_line(LinkOptions options, std::uint32_t baud) {
    constexpr std::size_t least = 256;
    options.queue_bytes = std::min(options.queue_bytes, std::max<std::size_t>(least, baud / 100));
    return options;
}

OpenDatagramPort serial_port(asio::io_context& io, const SerialAddress& address) {
    return [&io, device = address.device, baud = address.baud] { return open_serial_port(io, device, baud); };
}

Result<DtlsContext> context_of(const std::optional<TlsCredentials>& credentials) {
    return credentials ? make_dtls_context(*credentials) : Result<DtlsContext>(DtlsContext());
}

// Puts the address before the system's reason.
Error about(const LinkAddress& address, const Error& error) {
    return {error.kind, text(address) + ": " + error.text};
}

}  // namespace

std::string UdpAddress::text() const { return "udp:" + host_and_port(host, port); }
std::string SerialAddress::text() const { return "serial:" + device; }

Result<std::unique_ptr<Listener>> listen_on(asio::io_context& io, const UdpAddress& address,
                                            const LinkOptions& options) {
    AFFERENT_TRY(found, endpoint_of(address));
    AFFERENT_TRY(keys, context_of(address.credentials));
    auto port = open_udp_port(io, found, options);
    if (!port) return about(address, port.error());
    UdpAddress bound = address;
    bound.port = found.port();
    return make_datagram_listener(
        io, bound, std::move(port).value(),
        [&io, endpoint = found, options]() mutable { return open_udp_port(io, endpoint, options); },
        std::move(keys), options);
}

Result<std::unique_ptr<Listener>> listen_on(asio::io_context& io, const SerialAddress& address,
                                            const LinkOptions& options) {
    AFFERENT_TRY(keys, context_of(address.credentials));
    const OpenDatagramPort open = serial_port(io, address);
    auto port = open();
    if (!port) return about(address, port.error());
    return make_datagram_listener(io, address, std::move(port).value(), open, std::move(keys),
                                  for_line(options, address.baud));
}

std::unique_ptr<Connector> connector_to(asio::io_context& io, const UdpAddress& address,
                                        const Patience& patience, const LinkOptions& options) {
    return make_datagram_connector(
        io, address,
        [&io, found = endpoint_of(address), options]() -> Result<std::shared_ptr<DatagramPort>> {
            AFFERENT_TRY(peer, found);
            return open_udp_port_to(io, peer, options);
        },
        context_of(address.credentials), patience, options);
}

std::unique_ptr<Connector> connector_to(asio::io_context& io, const SerialAddress& address,
                                        const Patience& patience, const LinkOptions& options) {
    return make_datagram_connector(io, address, serial_port(io, address), context_of(address.credentials),
                                   patience, for_line(options, address.baud));
}

}  // namespace afferent
