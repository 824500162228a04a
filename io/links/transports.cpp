#include "afferent/io/links/transports.hpp"

#include "afferent/io/links/datagram_transports.hpp"
#include "afferent/io/links/sockets.hpp"
#include "afferent/io/links/tls.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;

template <class Address>
constexpr bool is_socket = std::is_same_v<Address, UnixAddress> || std::is_same_v<Address, TcpAddress>;

}  // namespace

Result<std::unique_ptr<Listener>> open_listener(asio::io_context& io, const LinkAddress& address,
                                                const LinkOptions& options) {
    return std::visit(
        [&]<class Address>(const Address& one) {
            if constexpr (is_socket<Address>)
                return open_socket_listener(io, one, options);
            else if constexpr (std::is_same_v<Address, TlsAddress>)
                return open_tls_listener(io, one, options);
            else
                return open_datagram_listener(io, one, options);
        },
        address);
}

std::unique_ptr<Connector> make_connector(asio::io_context& io, const LinkAddress& address,
                                          const Patience& patience, const LinkOptions& options) {
    return std::visit(
        [&]<class Address>(const Address& one) {
            if constexpr (is_socket<Address>)
                return make_socket_connector(io, one, patience, options);
            else if constexpr (std::is_same_v<Address, TlsAddress>)
                return make_tls_connector(io, one, patience, options);
            else
                return make_datagram_connector(io, one, patience, options);
        },
        address);
}

}  // namespace afferent
