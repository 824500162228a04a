#include "afferent/io/datagram_connector.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "afferent/io/datagram_handshake.hpp"
#include "afferent/io/datagram_link.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using OnLink = std::function<void(Result<std::unique_ptr<Link>>)>;

// Receives for the port, on behalf of the attempt first and of the link then, which keeps it.
class PortReader : public std::enable_shared_from_this<PortReader> {
  public:
    explicit PortReader(std::shared_ptr<DatagramPort> port) : port_(std::move(port)) {}
    ~PortReader() { port_->close(); }
    PortReader(const PortReader&) = delete;
    PortReader& operator=(const PortReader&) = delete;

    // `before` and `failed` hear what happens before there is a link.
    void start(std::function<void(std::span<const std::byte>)> before,
               std::function<void(const Error&)> failed) {
        before_ = std::move(before);
        failed_ = std::move(failed);
        const auto with_self = [weak = weak_from_this()](auto call) {
            if (const auto self = weak.lock()) call(*self);
        };
        port_->start({.received =
                          [with_self](const DatagramPeer&, std::span<const std::byte> datagram) {
                              with_self([&](PortReader& self) { self.receive(datagram); });
                          },
                      .garbage =
                          [with_self](std::uint64_t pieces) {
                              with_self([&](PortReader& self) {
                                  if (const auto connection = self.connection_.lock())
                                      connection->count_forged(pieces);
                              });
                          },
                      .writable =
                          [with_self] {
                              with_self([](PortReader& self) {
                                  if (const auto connection = self.connection_.lock()) connection->writable();
                              });
                          },
                      .failed =
                          [with_self](const Error& error) {
                              with_self([&](PortReader& self) {
                                  if (const auto connection = self.connection_.lock())
                                      connection->fail(error);
                                  else if (const auto on_failure = self.failed_)
                                      on_failure(error);
                              });
                          }});
    }
    // Nobody is interested before there is a link.
    void stop() {
        before_ = nullptr;
        failed_ = nullptr;
    }

    void send(std::span<const std::byte> datagram) { port_->send({}, datagram); }

    std::shared_ptr<DatagramConnection> make_connection(asio::io_context& io, DatagramCodec codec,
                                                        const LinkOptions& options) {
        stop();
        auto connection = std::make_shared<DatagramConnection>(io, port_, DatagramPeer(), std::move(codec),
                                                               options, shared_from_this());
        connection_ = connection;
        return connection;
    }

  private:
    void receive(std::span<const std::byte> datagram) {
        if (const auto connection = connection_.lock()) {
            if (!connection->receive(datagram)) connection->count_forged(1);
        } else if (const auto before = before_) {
            before(datagram);
        }
    }

    std::shared_ptr<DatagramPort> port_;
    std::function<void(std::span<const std::byte>)> before_;
    std::function<void(const Error&)> failed_;
    std::weak_ptr<DatagramConnection> connection_;
};

// One call of start(), from the first knock to the callback.
class Attempt : public std::enable_shared_from_this<Attempt> {
  public:
    Attempt(asio::io_context& io, std::string address, OpenDatagramPort open,
            const std::optional<SecretKey>& key, const Patience& patience, const LinkOptions& options,
            OnLink on_link)
        : io_(io),
          address_(std::move(address)),
          open_(std::move(open)),
          knock_(key),
          patience_(patience),
          options_(options),
          on_link_(std::move(on_link)),
          timer_(io),
          pause_(patience.first_pause),
          last_reason_(key ? "nobody answers who has this key" : "nobody answers") {}

    void knock() {
        if (!reader_) open();
        if (!on_link_) return;
        if (reader_) reader_->send(knock_.datagram());
        const auto now = Clock::now();
        if (now >= began_ + patience_.limit)
            return report(Error{Error::Kind::unreachable, address_ + ": " + last_reason_ + " (tried for " +
                                                              std::to_string(patience_.limit.count()) +
                                                              " ms)"});
        timer_.expires_at(std::min(now + pause_, began_ + patience_.limit));
        pause_ = std::min(2 * pause_, patience_.longest_pause);
        timer_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
            if (!error) self->knock();
        });
    }

    void call_off() {
        on_link_ = nullptr;
        timer_.cancel();
        if (reader_) reader_->stop();
        reader_.reset();
    }

  private:
    void open() {
        auto port = open_();
        if (!port) {
            last_reason_ = port.error().text;
            if (port.error().kind == Error::Kind::not_allowed) report(port.error());
            return;
        }
        reader_ = std::make_shared<PortReader>(std::move(port).value());
        reader_->start(
            [weak = weak_from_this()](std::span<const std::byte> datagram) {
                const auto self = weak.lock();
                if (!self) return;
                if (auto codec = self->knock_.answered_by(datagram)) self->has_reply(std::move(*codec));
            },
            [weak = weak_from_this()](const Error& error) {
                const auto self = weak.lock();
                if (!self) return;
                self->last_reason_ = error.text;
                self->reader_.reset();
            });
    }

    void has_reply(DatagramCodec codec) {
        report(make_datagram_link(reader_->make_connection(io_, std::move(codec), options_)));
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
    Knock knock_;
    Patience patience_;
    LinkOptions options_;
    OnLink on_link_;
    asio::steady_timer timer_;
    Clock::time_point began_ = Clock::now();
    std::chrono::milliseconds pause_;
    std::string last_reason_;
    std::shared_ptr<PortReader> reader_;
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
        asio::post(io_, [attempt = attempt_] { attempt->knock(); });
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
