#include "afferent/io/links/datagram_listener.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <utility>

#include "afferent/io/links/datagram_connection.hpp"
#include "afferent/io/links/dtls_acceptor.hpp"
#include "afferent/io/links/waiting_datagrams.hpp"
#include "afferent/io/wire/frame.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds reopening_pause{250};
// How long a datagram may be under way on one machine. One that comes later must have been sent later.
constexpr std::chrono::milliseconds longest_way{50};
constexpr std::chrono::milliseconds handshake_tick{10};
// How many frames of strangers are examined while there is a link, and how many peers without keys are
// answered.
constexpr int strangers_per_second = 100;

// Receives for the port. Outlives the listener if a link that it handed over does.
class ListeningPort final : public DatagramPortUser, public std::enable_shared_from_this<ListeningPort> {
  public:
    ListeningPort(asio::io_context& io, std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
                  DtlsContext keys, const LinkOptions& options)
        : io_(io),
          port_(std::move(port)),
          reopen_(std::move(reopen)),
          options_(options),
          timer_(io),
          handshake_timer_(io) {
        if (keys)
            dtls_.emplace(std::move(keys), port_->line(), [this](const DatagramPeer& to, auto datagram) {
                waiting_.send(*port_, to, datagram);
            });
    }
    ~ListeningPort() override { port_->close(); }
    ListeningPort(const ListeningPort&) = delete;
    ListeningPort& operator=(const ListeningPort&) = delete;

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) {
        on_peer_ = std::move(on_peer);
        if (!std::exchange(started_, true)) port_->start(weak_from_this());
    }
    void stop() {
        on_peer_ = nullptr;
        timer_.cancel();
        handshake_timer_.cancel();
    }

    std::uint64_t refused_peers() const noexcept { return refused_ + (dtls_ ? dtls_->refused() : 0); }
    std::uint64_t strays() const noexcept { return strays_; }

    void received(const DatagramPeer& from, std::span<const std::byte> datagram) override {
        const auto connection = living();
        if (dtls_)
            receive_sealed(connection.get(), from, datagram);
        else
            receive_plain(connection.get(), from, datagram);
    }
    void received_garbage(std::uint64_t pieces) override { count(pieces); }
    void writable() override {
        waiting_.flush(*port_);
        if (const auto connection = current_.lock()) connection->writable();
    }
    void failed(const Error& error) override {
        waiting_.clear();
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

    void receive_plain(DatagramConnection* link, const DatagramPeer& from,
                       std::span<const std::byte> datagram) {
        if (is_plain(datagram, DatagramKind::request)) return say(from, DatagramKind::reply);
        if (link != nullptr && from == link->peer()) return void(link->receive(from, datagram));
        proto::Envelope message;
        FrameCounts ignored;
        const bool looked_into = on_peer_ && (link == nullptr || strangers_.take(Clock::now()).count() == 0);
        if (!looked_into || !read_datagram(datagram, message, ignored) || !message.has_hello())
            return count(1);
        if (makes_way(link, from)) {
            // Its link began with a request and a reply.
            const std::byte asked = byte_of(DatagramKind::request);
            const std::size_t bytes = port_->line().bytes_of(std::span(&asked, 1));
            return accept(from, DatagramCodec(), {bytes, bytes}, {datagram.begin(), datagram.end()},
                          datagram);
        }
        if (is_second(*link)) port_->send(from, writer_.datagram(refusal_of(message)));
    }

    // Datagrams of other sessions are told apart before anything is computed: by the first byte, the length,
    // the number of the key and the counter.
    void receive_sealed(DatagramConnection* link, const DatagramPeer& from,
                        std::span<const std::byte> datagram) {
        auto how = DatagramCodec::Unwrapped::forged;
        if (link != nullptr && is_taken(how = link->receive(from, datagram))) return;
        const auto now = Clock::now();
        if (on_peer_ && is_dtls(datagram)) {
            if (!dtls_->receive(from, datagram, now)) count(1);
            return look_after_handshakes();
        }
        std::vector<std::byte> frame;
        auto* const peer = on_peer_ ? dtls_->peer_of(from, datagram, frame, now) : nullptr;
        if (peer == nullptr) {
            if (is_plain(datagram, DatagramKind::request) && strangers_.take(now).count() == 0)
                say(from, DatagramKind::keyed);
            return link != nullptr ? link->count(how, datagram) : count(1);
        }
        if (makes_way(link, from)) {
            DatagramCodec codec = std::move(*peer->codec);
            const CarriedBytes handshake = peer->carried;
            dtls_->remove(*peer);
            return accept(from, std::move(codec), handshake, std::move(frame), datagram);
        }
        proto::Envelope message;
        FrameCounts ignored;
        if (!is_second(*link) || !read_datagram(frame, message, ignored) || !message.has_hello()) return;
        std::vector<std::byte> refusal;
        peer->codec->wrap(writer_.datagram(refusal_of(message)), refusal, now);
        port_->send(from, refusal);
    }

    void say(const DatagramPeer& to, DatagramKind kind) {
        const std::byte said = byte_of(kind);
        port_->send(to, std::span(&said, 1));
    }

    // The new peer may be the same coprocessor, restarted: then the old link falls silent, and the new one
    // takes its place.
    bool makes_way(DatagramConnection* link, const DatagramPeer& to) {
        const auto now = Clock::now();
        if (link == nullptr) return true;
        if (now > link->heard() + options_.alive_limit) {
            link->fail({Error::Kind::closed, "the coprocessor has started again"});
            return true;
        }
        if (rival_ && rival_->peer == to) return false;
        ++refused_;
        rival_ = Rival{.peer = to, .since = now};
        return false;
    }
    // While the old link is still heard, the rival is another coprocessor.
    bool is_second(const DatagramConnection& link) const {
        return link.heard() > rival_->since + longest_way;
    }
    static proto::Envelope refusal_of(const proto::Envelope& asked) {
        proto::Envelope refusal;
        refusal.mutable_answer()->set_nonce(asked.hello().nonce());
        refusal.mutable_answer()->set_refusal("another coprocessor is connected");
        refusal.mutable_answer()->set_busy(true);
        return refusal;
    }

    void accept(const DatagramPeer& from, DatagramCodec codec, const CarriedBytes& handshake,
                std::vector<std::byte> first, std::span<const std::byte> first_datagram) {
        const auto made = std::make_shared<DatagramConnection>(io_, port_, from, std::move(codec), options_,
                                                               shared_from_this());
        made->count_handshake(handshake);
        made->receive_first(std::move(first), first_datagram);
        current_ = made;
        rival_.reset();
        // The callback may destroy the listener, and with it the function that is running.
        const auto on_peer = on_peer_;
        if (on_peer) on_peer(std::make_unique<ConnectionLink>(made));
    }

    void look_after_handshakes() {
        if (dtls_->peers() == 0 || std::exchange(looking_after_, true)) return;
        handshake_timer_.expires_after(handshake_tick);
        handshake_timer_.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
            const auto self = weak.lock();
            if (error || !self) return;
            self->looking_after_ = false;
            self->dtls_->look_after(Clock::now());
            self->look_after_handshakes();
        });
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
    LinkOptions options_;
    asio::steady_timer timer_;
    asio::steady_timer handshake_timer_;
    std::optional<DtlsAcceptor> dtls_;  // where the link has keys
    WaitingDatagrams waiting_;
    bool looking_after_ = false;
    RateLimit strangers_{strangers_per_second, strangers_per_second};
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
    DatagramListener(LinkAddress address, std::shared_ptr<ListeningPort> holder)
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
    std::shared_ptr<ListeningPort> holder_;
};

}  // namespace

std::unique_ptr<Listener> make_datagram_listener(asio::io_context& io, const LinkAddress& address,
                                                 std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
                                                 DtlsContext keys, const LinkOptions& options) {
    return std::make_unique<DatagramListener>(
        address,
        std::make_shared<ListeningPort>(io, std::move(port), std::move(reopen), std::move(keys), options));
}

}  // namespace afferent
