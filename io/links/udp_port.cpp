#include "afferent/io/links/udp_port.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/error.hpp>
#include <boost/asio/io_context.hpp>
#include <utility>

#include "afferent/io/wire/frame.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

// Holds what arrives within some milliseconds at 50,000 datagrams a second.
constexpr int strangers_bytes = 1 << 20;

// Errors that report on a datagram sent before. They may be forged, and the next datagram may arrive.
bool is_hearsay(const error_code& error) {
    return error == asio::error::connection_refused || error == asio::error::host_unreachable ||
           error == asio::error::network_unreachable || error == asio::error::message_size;
}

class UdpPort final : public DatagramPort, public std::enable_shared_from_this<UdpPort> {
  public:
    explicit UdpPort(udp::socket socket) : socket_(std::move(socket)) {}

    void start(std::weak_ptr<DatagramPortUser> user) override {
        user_ = std::move(user);
        receive();
    }

    std::size_t send(const DatagramPeer& to, std::span<const std::byte> datagram) override {
        error_code error;
        const asio::const_buffer bytes(datagram.data(), datagram.size());
        // A connected socket knows its peer. The error of an earlier datagram is reported once; then try
        // again.
        for (int attempt = 0; attempt < 2; ++attempt) {
            if (to == DatagramPeer())
                socket_.send(bytes, 0, error);
            else
                socket_.send_to(bytes, to, 0, error);
            if (error != asio::error::connection_refused) break;
        }
        if (error != asio::error::would_block && error != asio::error::no_buffer_space)
            return datagram.size();
        if (!std::exchange(waiting_, true))
            socket_.async_wait(udp::socket::wait_write, [self = shared_from_this()](const error_code&) {
                self->waiting_ = false;
                if (const auto user = self->user_.lock()) user->writable();
            });
        return 0;
    }

    void close() override {
        user_.reset();
        error_code ignored;
        socket_.close(ignored);
    }

  private:
    // After this many datagrams the loop goes on to others.
    static constexpr int most_at_once = 64;

    void receive() {
        socket_.async_receive_from(asio::buffer(bytes_), from_,
                                   [self = shared_from_this()](const error_code& error, std::size_t count) {
                                       self->has_received(error, count);
                                   });
    }

    void has_received(error_code error, std::size_t count) {
        for (int taken = 1;; ++taken) {
            const auto user = user_.lock();
            if (!user) return;
            if (!error) {
                user->received(from_, std::span(bytes_).first(count));
            } else if (!is_hearsay(error)) {
                close();
                return user->failed({Error::Kind::closed, error.message()});
            }
            if (!socket_.is_open()) return;
            if (taken == most_at_once) break;
            count = socket_.receive_from(asio::buffer(bytes_), from_, 0, error);
            if (error == asio::error::would_block) break;
        }
        receive();
    }

    udp::socket socket_;
    std::weak_ptr<DatagramPortUser> user_;
    DatagramPeer from_;
    bool waiting_ = false;
    std::array<std::byte, longest_datagram_bytes> bytes_;
};

// A port whose socket set_up has bound or connected.
template <class SetUp>
Result<std::shared_ptr<DatagramPort>> open_port(asio::io_context& io, const udp& protocol,
                                                const LinkOptions& options, const SetUp& set_up) {
    udp::socket socket(io);
    error_code error;
    socket.open(protocol, error);
    if (!error) socket.non_blocking(true, error);
    error_code ignored;
    const auto bytes = static_cast<int>(options.kernel_buffer_bytes);
    socket.set_option(asio::socket_base::send_buffer_size(bytes), ignored);
    // Strangers fill it, too. The system grants what it allows; what is read too late is refused for its age.
    socket.set_option(asio::socket_base::receive_buffer_size(std::max(bytes, strangers_bytes)), ignored);
    if (!error) set_up(socket, error);
    if (error) return Error{Error::Kind::unreachable, error.message()};
    return std::shared_ptr<DatagramPort>(std::make_shared<UdpPort>(std::move(socket)));
}

}  // namespace

Result<std::shared_ptr<DatagramPort>> open_udp_port(asio::io_context& io, udp::endpoint& endpoint,
                                                    const LinkOptions& options) {
    return open_port(io, endpoint.protocol(), options, [&](udp::socket& socket, error_code& error) {
        socket.bind(endpoint, error);
        if (!error) endpoint = socket.local_endpoint(error);
    });
}

Result<std::shared_ptr<DatagramPort>> open_udp_port_to(asio::io_context& io, const udp::endpoint& peer,
                                                       const LinkOptions& options) {
    return open_port(io, peer.protocol(), options,
                     [&](udp::socket& socket, error_code& error) { socket.connect(peer, error); });
}

}  // namespace afferent
