#include "afferent/io/links/sockets.hpp"

#include <boost/asio/io_context.hpp>
#include <utility>

#include "afferent/io/links/counted_stream.hpp"
#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/socket_transport.hpp"
#include "afferent/io/links/stream_connection.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;

Secure plain(const LinkOptions& options) {
    return [options](StreamSocket socket, StreamRole, const CallOff&, const OnStreamPeer& done) {
        done(plain_connection(std::move(socket), options));
    };
}

template <class Address>
std::unique_ptr<Connector> plain_connector(asio::io_context& io, const Address& address,
                                           const Patience& patience, const LinkOptions& options) {
    const auto attempt = [&]() -> Result<std::unique_ptr<ConnectionAttempt>> {
        AFFERENT_TRY(endpoint, endpoint_of(address));
        return make_socket_attempt(io, endpoint, plain(options), options);
    };
    return make_stream_connector(io, address, attempt(), patience);
}

}  // namespace

std::shared_ptr<StreamPeer> plain_connection(StreamSocket socket, const LinkOptions& options) {
    using Plain = CountedStream<StreamSocket>;
    return std::make_shared<StreamConnection<Plain>>(Plain(std::move(socket)), options);
}

std::string UnixAddress::text() const { return "unix:" + path; }
std::string TcpAddress::text() const { return "tcp:" + host_and_port(host, port); }

Result<std::unique_ptr<Listener>> listen_on(asio::io_context& io, const UnixAddress& address,
                                            const LinkOptions& options) {
    AFFERENT_TRY(endpoint, endpoint_of(address));
    remove_if_abandoned(io, address.path);
    return open_socket_listener(io, address, endpoint, plain(options), options);
}

Result<std::unique_ptr<Listener>> listen_on(asio::io_context& io, const TcpAddress& address,
                                            const LinkOptions& options) {
    AFFERENT_TRY(endpoint, endpoint_of(address));
    return open_socket_listener(io, address, endpoint, plain(options), options);
}

std::unique_ptr<Connector> connector_to(asio::io_context& io, const UnixAddress& address,
                                        const Patience& patience, const LinkOptions& options) {
    return plain_connector(io, address, patience, options);
}

std::unique_ptr<Connector> connector_to(asio::io_context& io, const TcpAddress& address,
                                        const Patience& patience, const LinkOptions& options) {
    return plain_connector(io, address, patience, options);
}

}  // namespace afferent
