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
#include "afferent/io/links/datagram_handshake.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using OnLink = std::function<void(Result<std::unique_ptr<Link>>)>;

// Receives for the port, on behalf of the attempt first and of the link then, which keeps it.
class PortHolder final : public DatagramPortUser, public std::enable_shared_from_this<PortHolder> {
  public:
    // What happens before there is a link.
    struct Early {
        std::function<void(std::span<const std::byte>)> received;
        std::function<void(const Error&)> failed;
    };

    explicit PortHolder(std::shared_ptr<DatagramPort> port) : port_(std::move(port)) {}
    ~PortHolder() override { port_->close(); }
    PortHolder(const PortHolder&) = delete;
    PortHolder& operator=(const PortHolder&) = delete;

    void start(Early early) {
        early_ = std::make_shared<const Early>(std::move(early));
        port_->start(weak_from_this());
    }
    void stop() { early_.reset(); }
    void send(std::span<const std::byte> datagram) { port_->send({}, datagram); }

    std::shared_ptr<DatagramConnection> make_connection(asio::io_context& io, DatagramCodec codec,
                                                        const LinkOptions& options) {
        stop();
        auto connection = std::make_shared<DatagramConnection>(io, port_, DatagramPeer(), std::move(codec),
                                                               options, shared_from_this());
        connection_ = connection;
        return connection;
    }

    void received(const DatagramPeer&, std::span<const std::byte> datagram) override {
        if (const auto connection = connection_.lock()) {
            if (!connection->receive(datagram)) connection->count_forged(1);
        } else if (const auto early = early_) {
            early->received(datagram);
        }
    }
    void received_garbage(std::uint64_t pieces) override {
        if (const auto connection = connection_.lock()) connection->count_forged(pieces);
    }
    void writable() override {
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
    std::shared_ptr<const Early> early_;  // they may stop us while they run
    std::weak_ptr<DatagramConnection> connection_;
};

// One call of start(), from the first request to the callback.
class Attempt : public std::enable_shared_from_this<Attempt> {
  public:
    Attempt(asio::io_context& io, std::string address, OpenDatagramPort open,
            const std::optional<SecretKey>& key, const Patience& patience, const LinkOptions& options,
            OnLink on_link)
        : io_(io),
          address_(std::move(address)),
          open_(std::move(open)),
          initiator_(key),
          patience_(patience),
          options_(options),
          on_link_(std::move(on_link)),
          timer_(io),
          pause_(patience.first_pause),
          last_reason_(key ? "no answer from a listener with this key" : "no answer") {}

    void send_request() {
        if (on_link_ && !holder_) open();
        if (!on_link_) return;
        if (holder_) holder_->send(initiator_.request());
        const auto now = Clock::now();
        if (now >= began_ + patience_.limit)
            return report(Error{Error::Kind::unreachable, address_ + ": " + last_reason_ + " (tried for " +
                                                              std::to_string(patience_.limit.count()) +
                                                              " ms)"});
        timer_.expires_at(std::min(now + pause_, began_ + patience_.limit));
        pause_ = std::min(2 * pause_, patience_.longest_pause);
        timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
            if (!error) self->send_request();
        });
    }

    void call_off() {
        on_link_ = nullptr;
        timer_.cancel();
        if (holder_) holder_->stop();
        holder_.reset();
    }

  private:
    void open() {
        auto port = open_();
        if (!port) {
            last_reason_ = port.error().text;
            if (port.error().kind == Error::Kind::not_allowed) report(port.error());
            return;
        }
        holder_ = std::make_shared<PortHolder>(std::move(port).value());
        holder_->start({.received =
                            [weak = weak_from_this()](std::span<const std::byte> datagram) {
                                if (const auto self = weak.lock()) self->receive(datagram);
                            },
                        .failed =
                            [weak = weak_from_this()](const Error& error) {
                                const auto self = weak.lock();
                                if (!self) return;
                                self->last_reason_ = error.text;
                                self->holder_.reset();
                            }});
    }

    void receive(std::span<const std::byte> datagram) {
        if (auto codec = initiator_.answered_by(datagram))
            report(std::unique_ptr<Link>(
                new ConnectionLink(holder_->make_connection(io_, std::move(*codec), options_))));
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
    Initiator initiator_;
    Patience patience_;
    LinkOptions options_;
    OnLink on_link_;
    asio::steady_timer timer_;
    Clock::time_point began_ = Clock::now();
    std::chrono::milliseconds pause_;
    std::string last_reason_;
    std::shared_ptr<PortHolder> holder_;
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
        // Callbacks come from the loop alone.
        asio::post(io_, [attempt = attempt_] { attempt->send_request(); });
    }

  private:
    asio::io_context& io_;
    MakeAttempt make_;
    std::shared_ptr<Attempt> attempt_;
};

}  // namespace

std::unique_ptr<Connector> make_datagram_connector(asio::io_context& io, const LinkAddress& address,
                                                   OpenDatagramPort open, const std::optional<SecretKey>& key,
                                                   const Patience& patience, const LinkOptions& options) {
    return std::make_unique<DatagramConnector>(
        io, [&io, name = text(address), open = std::move(open), key, patience, options](OnLink on_link) {
            return std::make_shared<Attempt>(io, name, open, key, patience, options, std::move(on_link));
        });
}

}  // namespace afferent
