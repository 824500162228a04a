#include "afferent/io/links/datagram_connector.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "afferent/io/links/datagram_connection.hpp"
#include "afferent/io/links/dtls.hpp"
#include "afferent/io/links/waiting_datagrams.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using OnLink = std::function<void(Result<std::unique_ptr<Link>>)>;

// Receives for the port, first for the attempt and then for the link, which keeps it alive.
class ConnectingPort final : public DatagramPortUser, public std::enable_shared_from_this<ConnectingPort> {
  public:
    // The callbacks until there is a link.
    struct Early {
        std::function<void(std::span<const std::byte>)> received;
        std::function<void(const Error&)> failed;
    };

    explicit ConnectingPort(std::shared_ptr<DatagramPort> port) : port_(std::move(port)) {}
    ~ConnectingPort() override { port_->close(); }
    ConnectingPort(const ConnectingPort&) = delete;
    ConnectingPort& operator=(const ConnectingPort&) = delete;

    void start(Early early) {
        early_ = std::make_shared<const Early>(std::move(early));
        port_->start(weak_from_this());
    }
    void stop() { early_.reset(); }
    DatagramLine line() const { return port_->line(); }
    void send(std::span<const std::byte> datagram) {
        const std::size_t bytes = port_->line().bytes_of(datagram);
        // Before the first answer only the last datagram counts: the others have not reached anybody.
        early_bytes_.out = early_bytes_.in == 0 ? bytes : early_bytes_.out + bytes;
        waiting_.send(*port_, {}, datagram);
    }

    std::shared_ptr<DatagramConnection> make_connection(asio::io_context& io, DatagramCodec codec,
                                                        const LinkOptions& options) {
        auto connection = std::make_shared<DatagramConnection>(io, port_, DatagramPeer(), std::move(codec),
                                                               options, shared_from_this());
        connection->count_handshake(early_bytes_);
        connection_ = connection;
        return connection;
    }

    void received(const DatagramPeer& from, std::span<const std::byte> datagram) override {
        if (const auto connection = connection_.lock()) {
            // The last flight of the handshake may come twice.
            if (!is_dtls(datagram)) connection->count(connection->receive(from, datagram), datagram);
        } else if (const auto early = early_) {
            early_bytes_.in += port_->line().bytes_of(datagram);
            early->received(datagram);
        }
    }
    void received_garbage(std::uint64_t pieces) override {
        if (const auto connection = connection_.lock()) connection->count_forged(pieces);
    }
    void writable() override {
        waiting_.flush(*port_);
        if (const auto connection = connection_.lock()) connection->writable();
    }
    void failed(const Error& error) override {
        if (const auto connection = connection_.lock())
            connection->fail(error);
        else if (const auto early = early_)
            early->failed(error);
    }

  private:
    std::shared_ptr<DatagramPort> port_;
    WaitingDatagrams waiting_;
    CarriedBytes early_bytes_;
    std::shared_ptr<const Early> early_;  // they may stop us while they run
    std::weak_ptr<DatagramConnection> connection_;
};

// One call of start(), from the first request to the callback.
class Attempt : public std::enable_shared_from_this<Attempt> {
  public:
    Attempt(asio::io_context& io, std::string address, OpenDatagramPort open, Result<DtlsContext> keys,
            const Patience& patience, const LinkOptions& options, OnLink on_link)
        : io_(io),
          address_(std::move(address)),
          open_(std::move(open)),
          keys_(std::move(keys)),
          patience_(patience),
          options_(options),
          on_link_(std::move(on_link)),
          timer_(io),
          pause_(patience.first_pause) {
        if (keys_ && keys_.value())
            last_reason_ = {Error::Kind::unreachable, "no answer from a listener with keys"};
    }

    // Does what is due, and sets the timer for what is next.
    void proceed() {
        if (!on_link_) return;
        if (!keys_) return report(keys_.error());
        if (!holder_) open();
        const auto now = Clock::now();
        const auto end = began_ + patience_.limit;
        if (now >= end)
            return report(Error{last_reason_.kind, address_ + ": " + last_reason_.text + " (tried for " +
                                                       std::to_string(patience_.limit.count()) + " ms)"});
        const auto next = next_step(now);
        if (!on_link_) return;  // open() or next_step() has reported
        timer_.expires_at(std::min(next, end));
        timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
            if (!error) self->proceed();
        });
    }

    void call_off() {
        on_link_ = nullptr;
        timer_.cancel();
        if (holder_) holder_->stop();
        handshake_.reset();
        holder_.reset();
    }

  private:
    void open() {
        auto port = open_();
        if (!port) {
            last_reason_ = {Error::Kind::unreachable, port.error().text};
            if (port.error().kind == Error::Kind::not_allowed) report(port.error());
            return;
        }
        holder_ = std::make_shared<ConnectingPort>(std::move(port).value());
        holder_->start({.received =
                            [weak = weak_from_this()](std::span<const std::byte> datagram) {
                                if (const auto self = weak.lock()) self->receive(datagram);
                            },
                        .failed =
                            [weak = weak_from_this()](const Error& error) {
                                const auto self = weak.lock();
                                if (!self) return;
                                self->last_reason_ = {Error::Kind::unreachable, error.text};
                                self->handshake_.reset();
                                self->holder_.reset();
                            }});
    }

    Clock::time_point next_step(Clock::time_point now) {
        if (holder_ && keys_.value()) {
            if (handshake_ && now < give_up_at_) handshake_->look_after();
            if (!handshake_ || now >= give_up_at_) begin_handshake(now);
            conclude();
            if (handshake_) return now + handshake_->pause();
        } else if (holder_) {
            const std::byte request = byte_of(DatagramKind::request);
            holder_->send(std::span(&request, 1));
        }
        const auto next = now + pause_;
        pause_ = std::min(2 * pause_, patience_.longest_pause);
        return next;
    }

    // A listener that was restarted does not know the handshake that is under way.
    void begin_handshake(Clock::time_point now) {
        const DatagramLine line = holder_->line();
        handshake_ = std::make_unique<DtlsHandshake>(keys_.value(), DtlsHandshake::Role::connects, line,
                                                     [this](auto datagram) { holder_->send(datagram); });
        give_up_at_ = now + 2 * DtlsHandshake::patience(line);
        handshake_->start();
    }

    void receive(std::span<const std::byte> datagram) {
        if (handshake_ && is_dtls(datagram)) {
            handshake_->receive(datagram);
            conclude();
        } else if (!keys_.value() && is_plain(datagram, DatagramKind::reply)) {
            connect(DatagramCodec());
        } else if (!keys_.value() && is_plain(datagram, DatagramKind::keyed)) {
            last_reason_ = {Error::Kind::not_allowed, "the listener has keys; give the scene link.keys"};
        }
    }

    // A failure proves nothing: it may be forged. So the attempt goes on until patience ends.
    void conclude() {
        if (handshake_->state() == DtlsHandshake::State::under_way) return;
        if (handshake_->state() == DtlsHandshake::State::done) {
            auto codec = handshake_->codec(Clock::now());
            if (codec) return connect(std::move(codec).value());
            last_reason_ = codec.error();
        } else {
            last_reason_ = {Error::Kind::not_allowed, handshake_->failure()};
        }
        handshake_.reset();
    }

    void connect(DatagramCodec codec) {
        report(std::unique_ptr<Link>(
            new ConnectionLink(holder_->make_connection(io_, std::move(codec), options_))));
    }

    void report(Result<std::unique_ptr<Link>> result) {
        const auto on_link = std::exchange(on_link_, nullptr);
        call_off();
        // The callback may start the next attempt.
        if (on_link) on_link(std::move(result));
    }

    asio::io_context& io_;
    std::string address_;
    OpenDatagramPort open_;
    Result<DtlsContext> keys_;
    Patience patience_;
    LinkOptions options_;
    OnLink on_link_;
    asio::steady_timer timer_;
    Clock::time_point began_ = Clock::now();
    std::chrono::milliseconds pause_;
    Error last_reason_{Error::Kind::unreachable, "no answer"};
    std::shared_ptr<ConnectingPort> holder_;
    std::unique_ptr<DtlsHandshake> handshake_;
    Clock::time_point give_up_at_;
};

class DatagramConnector final : public Connector {
  public:
    using MakeAttempt = std::function<std::shared_ptr<Attempt>(OnLink)>;

    DatagramConnector(asio::io_context& io, MakeAttempt make) : io_(io), make_(std::move(make)) {}
    ~DatagramConnector() override {
        if (attempt_) attempt_->call_off();
    }

    void start(OnLink on_link) override {
        if (attempt_) attempt_->call_off();
        attempt_ = make_(std::move(on_link));
        // Callbacks are called from the loop only, not from within this call.
        asio::post(io_, [attempt = attempt_] { attempt->proceed(); });
    }

  private:
    asio::io_context& io_;
    MakeAttempt make_;
    std::shared_ptr<Attempt> attempt_;
};

}  // namespace

std::unique_ptr<Connector> make_datagram_connector(asio::io_context& io, const LinkAddress& address,
                                                   OpenDatagramPort open, Result<DtlsContext> keys,
                                                   const Patience& patience, const LinkOptions& options) {
    return std::make_unique<DatagramConnector>(
        io, [&io, name = text(address), open = std::move(open), keys = std::move(keys), patience,
             options](OnLink on_link) {
            return std::make_shared<Attempt>(io, name, open, keys, patience, options, std::move(on_link));
        });
}

}  // namespace afferent
