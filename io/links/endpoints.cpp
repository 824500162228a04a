#include "afferent/io/links/endpoints.hpp"

#include <sys/un.h>

#include <boost/asio/ip/address.hpp>

namespace afferent {
namespace {

namespace asio = boost::asio;

Error not_allowed(const LinkAddress& address, const std::string& text) {
    return {Error::Kind::not_allowed, afferent::text(address) + ": " + text};
}

// The host is an address in digits, or localhost.
template <class Endpoint, class Address>
Result<Endpoint> internet_endpoint(const Address& address, bool has_keys) {
    boost::system::error_code error;
    const auto host =
        asio::ip::make_address(address.host == "localhost" ? "127.0.0.1" : address.host.c_str(), error);
    if (error) return not_allowed(address, "the host must be localhost or an address in digits");
    if (!has_keys && !host.is_loopback())
        return not_allowed(address,
                           "leaves this machine, which only a link with keys may; give the scene link.keys");
    return Endpoint(host, address.port);
}

}  // namespace

Result<asio::local::stream_protocol::endpoint> endpoint_of(const UnixAddress& address) {
    // The path ends with a zero byte.
    constexpr std::size_t longest = sizeof(sockaddr_un::sun_path) - 1;
    if (address.path.empty() || address.path.size() > longest)
        return not_allowed(
            address, "the path of a Unix socket has from 1 to " + std::to_string(longest) + " characters");
    return asio::local::stream_protocol::endpoint(address.path);
}

Result<asio::ip::tcp::endpoint> endpoint_of(const TcpAddress& address) {
    return internet_endpoint<asio::ip::tcp::endpoint>(address, false);
}

Result<asio::ip::tcp::endpoint> endpoint_of(const TlsAddress& address) {
    return internet_endpoint<asio::ip::tcp::endpoint>(address, true);
}

Result<asio::ip::udp::endpoint> endpoint_of(const UdpAddress& address) {
    return internet_endpoint<asio::ip::udp::endpoint>(address, address.credentials.has_value());
}

std::string host_and_port(const std::string& host, std::uint16_t port) {
    const bool colons = host.find(':') != std::string::npos;
    return (colons ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Error system_error(Error::Kind kind, const LinkAddress& address, const boost::system::error_code& error) {
    return {kind, text(address) + ": " + error.message()};
}

}  // namespace afferent
