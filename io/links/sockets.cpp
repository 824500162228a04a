#include "afferent/io/links/sockets.hpp"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/stream_transport.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::local::stream_protocol;
using boost::system::error_code;

template <class Socket>
void set_buffers(Socket& socket, const LinkOptions& options) {
    // Where the system does not take an option the link works all the same, only less promptly.
    error_code ignored;
    const auto bytes = static_cast<int>(options.kernel_buffer_bytes);
    socket.set_option(asio::socket_base::send_buffer_size(bytes), ignored);
    socket.set_option(asio::socket_base::receive_buffer_size(bytes), ignored);
}

}  // namespace

void remove_if_abandoned(asio::io_context& io, const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return;
    stream_protocol::socket probe(io);
    error_code error;
    probe.connect(path, error);
    if (error == asio::error::connection_refused) ::unlink(path.c_str());
}

void tune(tcp::socket& socket, const LinkOptions& options) {
    using UserTimeout = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_USER_TIMEOUT>;
    error_code ignored;
    set_buffers(socket, options);
    socket.set_option(tcp::no_delay(true), ignored);
    socket.set_option(UserTimeout(static_cast<int>(options.silence_limit.count())), ignored);
}

void tune(stream_protocol::socket& socket, const LinkOptions& options) { set_buffers(socket, options); }

Result<std::unique_ptr<Listener>> open_socket_listener(asio::io_context& io, const UnixAddress& address,
                                                       const LinkOptions& options) {
    AFFERENT_TRY(found, endpoint_of(address));
    remove_if_abandoned(io, address.path);
    return open_stream_listener<stream_protocol>(
        io, address, found, Unsecured<stream_protocol::socket>(),
        [](const stream_protocol::endpoint& bound) { return UnixAddress{bound.path()}; }, options);
}

Result<std::unique_ptr<Listener>> open_socket_listener(asio::io_context& io, const TcpAddress& address,
                                                       const LinkOptions& options) {
    AFFERENT_TRY(found, endpoint_of(address));
    return open_stream_listener<tcp>(
        io, address, found, Unsecured<tcp::socket>(),
        [](const tcp::endpoint& bound) {
            return TcpAddress{bound.address().to_string(), bound.port()};
        },
        options);
}

std::unique_ptr<Connector> make_socket_connector(asio::io_context& io, const UnixAddress& address,
                                                 const Patience& patience, const LinkOptions& options) {
    using Securing = Unsecured<stream_protocol::socket>;
    return std::make_unique<StreamConnector<stream_protocol, Securing>>(io, address, endpoint_of(address),
                                                                        Securing(), patience, options);
}

std::unique_ptr<Connector> make_socket_connector(asio::io_context& io, const TcpAddress& address,
                                                 const Patience& patience, const LinkOptions& options) {
    using Securing = Unsecured<tcp::socket>;
    return std::make_unique<StreamConnector<tcp, Securing>>(io, address, endpoint_of(address), Securing(),
                                                            patience, options);
}

}  // namespace afferent
