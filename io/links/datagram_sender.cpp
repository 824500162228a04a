#include "afferent/io/links/datagram_sender.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/datagram_protocol.hpp>

#include "afferent/io/links/endpoints.hpp"

namespace afferent {

namespace asio = boost::asio;

struct DatagramSender::Socket {
    virtual ~Socket() = default;
    virtual bool send(std::span<const std::byte> datagram) = 0;
};

namespace {

template <class Protocol>
class SocketTo final : public DatagramSender::Socket {
  public:
    explicit SocketTo(typename Protocol::endpoint peer) : peer_(std::move(peer)) {}

    boost::system::error_code open() {
        boost::system::error_code error;
        socket_.open(peer_.protocol(), error);
        if (!error) socket_.non_blocking(true, error);
        return error;
    }

    bool send(std::span<const std::byte> datagram) override {
        boost::system::error_code error;
        socket_.send_to(asio::buffer(datagram.data(), datagram.size()), peer_, 0, error);
        return !error;
    }

  private:
    asio::io_context io_;
    typename Protocol::socket socket_{io_};
    typename Protocol::endpoint peer_;
};

template <class Protocol>
Result<std::shared_ptr<DatagramSender::Socket>> open_to(const typename Protocol::endpoint& peer,
                                                        const LinkAddress& address) {
    auto socket = std::make_shared<SocketTo<Protocol>>(peer);
    if (const auto error = socket->open()) return system_error(Error::Kind::unreachable, address, error);
    return std::shared_ptr<DatagramSender::Socket>(std::move(socket));
}

}  // namespace

Result<DatagramSender> DatagramSender::to_udp(const std::string& host, std::uint16_t port) {
    const UdpAddress address{host, port, std::nullopt};
    const auto peer = endpoint_of(address);
    if (!peer)
        return Error{
            Error::Kind::not_allowed,
            text(LinkAddress(address)) +
                ": must be localhost or a loopback address in digits: nothing protects what is sent"};
    AFFERENT_TRY(socket, open_to<asio::ip::udp>(peer.value(), address));
    return DatagramSender(std::move(socket));
}

Result<DatagramSender> DatagramSender::to_unix(const std::string& path) {
    const UnixAddress address{path};
    AFFERENT_TRY(stream, endpoint_of(address));
    AFFERENT_TRY(socket, open_to<asio::local::datagram_protocol>(stream.path(), address));
    return DatagramSender(std::move(socket));
}

bool DatagramSender::send(std::span<const std::byte> datagram) { return socket_->send(datagram); }

}  // namespace afferent
