#include "afferent/io/links/link_address.hpp"

namespace afferent {
namespace {

std::string host_and_port(const std::string& host, std::uint16_t port) {
    const bool colons = host.find(':') != std::string::npos;
    return (colons ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

struct Text {
    std::string operator()(const UnixAddress& address) const { return "unix:" + address.path; }
    std::string operator()(const TcpAddress& address) const {
        return "tcp:" + host_and_port(address.host, address.port);
    }
    std::string operator()(const TlsAddress& address) const {
        return "tls:" + host_and_port(address.host, address.port);
    }
    std::string operator()(const UdpAddress& address) const {
        return "udp:" + host_and_port(address.host, address.port);
    }
    std::string operator()(const SerialAddress& address) const { return "serial:" + address.device; }
};

}  // namespace

std::string text(const LinkAddress& address) { return std::visit(Text(), address); }

}  // namespace afferent
