#include "afferent/io/links/datagram_listener.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <utility>

#include "afferent/io/links/datagram_connection.hpp"
#include "afferent/io/links/datagram_handshake.hpp"
#include "afferent/io/wire/frame.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds reopening_pause{250};
// How long a datagram may be under way on one machine. One that comes later was sent later.
constexpr std::chrono::milliseconds longest_way{50};

// Receives for the port. Outlives the listener by the link that it has handed over.
class PortHolder final : public DatagramPortUser, public std::enable_shared_from_this<PortHolder> {
  public:
    PortHolder(asio::io_context& io, std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
               const std::optional<SecretKey>& key, const LinkOptions& options)
        : io_(io),
          port_(std::move(port)),
          reopen_(std::move(reopen)),
          responder_(key),
          options_(options),
          timer_(io) {}
    ~PortHolder() override { port_->close(); }
    PortHolder(const PortHolder&) = delete;
    PortHolder& operator=(const PortHolder&) = delete;

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) {
        on_peer_ = std::move(on_peer);
        if (!std::exchange(started_, true)) port_->start(weak_from_this());
    }
    void stop() {
        on_peer_ = nullptr;
        timer_.cancel();
    }

    std::uint64_t refused_peers() const noexcept { return refused_; }
    std::uint64_t strays() const noexcept { return strays_; }

    void received(const DatagramPeer& from, std::span<const std::byte> datagram) override {
        if (const auto reply = responder_.reply(datagram, Clock::now())) {
            port_->send(from, *reply);
            return;
        }
        const auto connection = living();
        if (connection && (responder_.sealed() || from == connection->peer()) &&
            connection->receive(datagram))
            return;
        auto accepted = on_peer_ ? responder_.accept(datagram, Clock::now()) : std::nullopt;
        if (!accepted) return count(1);
        if (connection) {
            if (!responder_.sealed()) return turn_away(*connection, from, accepted->frame);
            connection->fail({Error::Kind::closed, "the coprocessor has started again"});
        }
        const auto made = std::make_shared<DatagramConnection>(io_, port_, from, std::move(accepted->codec),
                                                               options_, shared_from_this());
        made->receive_first(std::move(accepted->frame));
        current_ = made;
        rival_.reset();
        // It may destroy the listener, and with it what it is called by.
        const auto on_peer = on_peer_;
        if (on_peer) on_peer(std::make_unique<ConnectionLink>(made));
    }

    void received_garbage(std::uint64_t pieces) override { count(pieces); }
    void writable() override {
        if (const auto connection = current_.lock()) connection->writable();
    }
    void failed(const Error& error) override {
        if (const auto connection = current_.lock()) connection->fail(error);
        wait_for_port();
    }

  private:
    std::shared_ptr<DatagramConnection> living() const {
        auto connection = current_.lock();
        return connection && connection->lives() ? connection : nullptr;
    }

    void count(std::uint64_t datagrams) {
        if (const auto connection = living())
            connection->count_forged(datagrams);
        else
            strays_ += datagrams;
    }

    // It may be the same coprocessor, started again: then the old link ends soon, and the new one is
    // accepted. While the old one is still heard, it is another coprocessor.
    void turn_away(const DatagramConnection& link, const DatagramPeer& from,
                   std::span<const std::byte> hello) {
        if (!rival_ || rival_->peer != from) {
            ++refused_;
            rival_ = Rival{.peer = from, .since = Clock::now()};
        } else if (link.heard() > rival_->since + longest_way) {
            proto::Envelope asked;
            FrameCounts ignored;
            if (!read_datagram(hello, asked, ignored)) return;
            proto::Envelope refusal;
            refusal.mutable_answer()->set_nonce(asked.hello().nonce());
            refusal.mutable_answer()->set_refusal("another coprocessor is connected");
            port_->send(from, writer_.datagram(refusal));
        }
    }

    void wait_for_port() {
        if (!on_peer_) return;
        timer_.expires_after(reopening_pause);
        timer_.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
            const auto self = weak.lock();
            if (error || !self || !self->on_peer_) return;
            auto port = self->reopen_();
            if (!port) return self->wait_for_port();
            self->port_ = std::move(port).value();
            self->port_->start(self);
        });
    }

    struct Rival {
        DatagramPeer peer;
        Clock::time_point since;
    };

    asio::io_context& io_;
    std::shared_ptr<DatagramPort> port_;
    OpenDatagramPort reopen_;
    Responder responder_;
    LinkOptions options_;
    asio::steady_timer timer_;
    std::function<void(std::unique_ptr<Link>)> on_peer_;
    bool started_ = false;
    std::weak_ptr<DatagramConnection> current_;
    std::optional<Rival> rival_;
    FrameWriter writer_;
    std::uint64_t refused_ = 0;
    std::uint64_t strays_ = 0;
};

class DatagramListener final : public Listener {
  public:
    DatagramListener(LinkAddress address, std::shared_ptr<PortHolder> holder)
        : address_(std::move(address)), holder_(std::move(holder)) {}
    ~DatagramListener() override { holder_->stop(); }

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
        holder_->start(std::move(on_peer));
    }
    LinkAddress address() const override { return address_; }
    std::uint64_t refused_peers() const override { return holder_->refused_peers(); }
    std::uint64_t strays() const override { return holder_->strays(); }

  private:
    LinkAddress address_;
    std::shared_ptr<PortHolder> holder_;
};

}  // namespace

std::unique_ptr<Listener> make_datagram_listener(asio::io_context& io, const LinkAddress& address,
                                                 std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
                                                 const std::optional<SecretKey>& key,
                                                 const LinkOptions& options) {
    return std::make_unique<DatagramListener>(
        address, std::make_shared<PortHolder>(io, std::move(port), std::move(reopen), key, options));
}

}  // namespace afferent
