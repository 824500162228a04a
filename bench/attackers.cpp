#include "bench/attackers.hpp"

#include <openssl/ssl.h>
#include <poll.h>

#include <array>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/hello.hpp"

namespace afferent::bench {
namespace {

namespace asio = boost::asio;
using asio::generic::stream_protocol;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using Socket = stream_protocol::socket;

const asio::ip::address here = asio::ip::address_v4::loopback();

stream_protocol::endpoint endpoint(const Victim& victim) {
    if (!victim.unix_path.empty()) return asio::local::stream_protocol::endpoint(victim.unix_path);
    return asio::ip::tcp::endpoint(here, victim.port);
}

// A connection that is reset when it is closed, so that no port waits for stray segments; nothing where the
// hand takes no more at the moment.
std::optional<Socket> connect(asio::io_context& io, const Victim& victim) {
    const auto to = endpoint(victim);
    Socket socket(io, to.protocol());
    if (victim.unix_path.empty()) socket.set_option(asio::socket_base::linger(true, 0));
    // Asio's own connect() would wait for room in the hand's queue.
    socket.native_non_blocking(true);
    const int refused = ::connect(socket.native_handle(), to.data(), static_cast<socklen_t>(to.size()));
    if (refused != 0) {
        if (errno != EINPROGRESS) return std::nullopt;
        pollfd ready{socket.native_handle(), POLLOUT, 0};
        if (::poll(&ready, 1, 0) != 1 || (ready.revents & POLLERR) != 0) return std::nullopt;
    }
    return socket;
}

// The first flight of a TLS client that nobody knows.
std::vector<char> client_hello() {
    const std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> context(SSL_CTX_new(TLS_client_method()),
                                                               SSL_CTX_free);
    const std::unique_ptr<SSL, void (*)(SSL*)> client(SSL_new(context.get()), SSL_free);
    BIO* const out = BIO_new(BIO_s_mem());
    SSL_set_bio(client.get(), BIO_new(BIO_s_mem()), out);
    SSL_connect(client.get());
    std::vector<char> bytes(BIO_ctrl_pending(out));
    if (bytes.empty() || BIO_read(out, bytes.data(), static_cast<int>(bytes.size())) <= 0)
        throw std::runtime_error("OpenSSL makes no hello");
    return bytes;
}

// The first flights of a DTLS client that nobody knows.
class DtlsClient {
  public:
    DtlsClient() {
        SSL_set_options(client_.get(), SSL_OP_NO_QUERY_MTU);
        SSL_set_mtu(client_.get(), 1200);
        SSL_set_bio(client_.get(), in_, out_);
    }

    // Its hello; after an answer the one that returns the cookie.
    std::vector<char> hello() {
        SSL_connect(client_.get());
        std::vector<char> bytes(BIO_ctrl_pending(out_));
        if (bytes.empty() || BIO_read(out_, bytes.data(), static_cast<int>(bytes.size())) <= 0)
            throw std::runtime_error("OpenSSL makes no hello");
        return bytes;
    }
    void hear(std::span<const char> answer) {
        BIO_write(in_, answer.data(), static_cast<int>(answer.size()));
    }

  private:
    std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> context_{SSL_CTX_new(DTLS_client_method()), SSL_CTX_free};
    std::unique_ptr<SSL, void (*)(SSL*)> client_{SSL_new(context_.get()), SSL_free};
    BIO* in_ = BIO_new(BIO_s_mem());
    BIO* out_ = BIO_new(BIO_s_mem());
};

// 127.0.0.2 and on: another host each, for all that the hand knows.
asio::ip::udp::socket stranger_at(asio::io_context& io, const Victim& victim, unsigned number) {
    asio::ip::udp::socket socket(io, {asio::ip::address_v4(0x7f000002 + number), 0});
    socket.connect({here, victim.port});
    return socket;
}

// Does it as often as that, however long it takes; returns how often.
template <class Do>
std::uint64_t at_rate(double per_s, const std::stop_token& stop, const Do& once) {
    const auto begin = Clock::now();
    std::uint64_t count = 0;
    while (!stop.stop_requested()) {
        const std::chrono::duration<double> elapsed = Clock::now() - begin;
        for (const auto due = static_cast<std::uint64_t>(elapsed.count() * per_s); count < due; ++count)
            once(count);
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return count;
}

// One who speaks the protocol, over the same links as a coprocessor does.
class Peer {
  public:
    explicit Peer(const Victim& victim)
        : connector_(
              make_connector(io_, victim.coprocessor,
                             {.limit = std::chrono::duration_cast<std::chrono::milliseconds>(patience)})) {
        connector_->start([this](Result<std::unique_ptr<Link>> link) {
            if (!link) return void(gone_ = true);
            link_ = std::move(link).value();
            link_->start(
                {.message = [this](const proto::Envelope& message) { answered_ |= message.has_answer(); },
                 .bad_frame = [](const Error&) {},
                 .closed = [this](const Error&) { gone_ = true; }});
        });
        wait_until([this] { return link_ != nullptr; });
    }

    bool connected() const { return link_ && !gone_; }
    // Whether it may be sent without waiting in our own queue.
    bool takes_more() const { return connected() && link_->queued_bytes() < 8192; }
    void send(const proto::Envelope& message) {
        if (connected()) link_->send(message);
    }
    // A session, as a coprocessor of the scene opens it. False: the hand does not want any.
    bool open(const Plan& plan) {
        proto::Envelope hello;
        *hello.mutable_hello() = make_hello(plan, false);
        send(hello);
        wait_until([this] { return answered_; });
        return answered_ && connected();
    }
    // Does what the link has to do meanwhile.
    void turn() {
        io_.restart();
        io_.poll();
    }
    // Until the hand has hung up, or for as long.
    void linger(Clock::duration most) {
        const auto end = Clock::now() + most;
        while (connected() && Clock::now() < end) wait(end);
    }

  private:
    static constexpr Clock::duration patience = std::chrono::milliseconds(500);

    template <class Condition>
    void wait_until(const Condition& condition) {
        const auto end = Clock::now() + patience;
        while (!condition() && !gone_ && Clock::now() < end) wait(end);
    }
    void wait(Clock::time_point end) {
        io_.restart();
        io_.run_one_until(end);
    }

    asio::io_context io_;
    std::unique_ptr<Link> link_;
    std::unique_ptr<Connector> connector_;
    bool answered_ = false;
    bool gone_ = false;
};

proto::Envelope bye() {
    proto::Envelope message;
    message.mutable_bye()->set_reason(proto::END_OF_SCENE);
    return message;
}

std::uint64_t say_byes(const Victim& victim, bool after_hello, const std::stop_token& stop) {
    std::uint64_t count = 0;
    while (!stop.stop_requested()) {
        Peer peer(victim);
        if (after_hello && !peer.open(victim.plan)) continue;
        if (!peer.connected()) continue;
        peer.send(bye());
        ++count;
        peer.linger(std::chrono::milliseconds(5));
    }
    return count;
}

}  // namespace

std::uint64_t connect_and_hang_up(const Victim& victim, const std::stop_token& stop) {
    asio::io_context io;
    std::uint64_t count = 0;
    while (!stop.stop_requested())
        if (connect(io, victim))
            ++count;
        else
            std::this_thread::yield();
    return count;
}

std::uint64_t begin_handshakes(const Victim& victim, const std::stop_token& stop) {
    constexpr std::size_t most_open = 64;
    const std::vector<char> hello = client_hello();
    asio::io_context io;
    std::deque<Socket> open;
    std::uint64_t count = 0;
    while (!stop.stop_requested()) {
        auto socket = connect(io, victim);
        if (!socket) {
            std::this_thread::yield();
            continue;
        }
        error_code error;
        socket->write_some(asio::buffer(hello), error);
        if (!error) ++count;
        open.push_back(std::move(*socket));
        if (open.size() > most_open) open.pop_front();
    }
    return count;
}

std::uint64_t hold_idle_connections(const Victim& victim, std::uint64_t count, const std::stop_token& stop) {
    asio::io_context io;
    std::vector<Socket> open;
    while (!stop.stop_requested()) {
        auto socket = open.size() < count ? connect(io, victim) : std::nullopt;
        if (socket)
            open.push_back(std::move(*socket));
        else
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return open.size();
}

std::uint64_t send_datagrams(const Victim& victim, std::size_t bytes, double per_s,
                             const std::stop_token& stop) {
    asio::io_context io;
    asio::ip::udp::socket socket(io, asio::ip::udp::v4());
    socket.connect({here, victim.port});
    std::mt19937_64 random(1);
    std::array<std::uint64_t, 8192> noise{};
    for (auto& word : noise) word = random();
    const auto all = std::as_bytes(std::span(noise));
    return at_rate(per_s, stop, [&](std::uint64_t) {
        const auto datagram = all.subspan(random() % (all.size() - bytes), bytes);
        error_code ignored;
        socket.send(asio::buffer(datagram.data(), datagram.size()), 0, ignored);
    });
}

std::uint64_t send_hellos(const Victim& victim, double per_s, const std::stop_token& stop) {
    constexpr unsigned hosts = 64;
    const std::vector<char> hello = DtlsClient().hello();
    asio::io_context io;
    std::vector<asio::ip::udp::socket> sockets;
    for (unsigned i = 0; i < hosts; ++i) sockets.push_back(stranger_at(io, victim, i));
    return at_rate(per_s, stop, [&](std::uint64_t number) {
        error_code ignored;
        sockets[number % hosts].send(asio::buffer(hello), 0, ignored);
    });
}

std::uint64_t return_cookies(const Victim& victim, const std::stop_token& stop) {
    asio::io_context io;
    std::array<char, 2048> answer{};
    std::uint64_t count = 0;
    while (!stop.stop_requested()) {
        auto socket = stranger_at(io, victim, static_cast<unsigned>(count % 64));
        DtlsClient client;
        error_code error;
        socket.send(asio::buffer(client.hello()), 0, error);
        pollfd ready{socket.native_handle(), POLLIN, 0};
        if (::poll(&ready, 1, 5) != 1) continue;
        const std::size_t bytes = socket.receive(asio::buffer(answer), 0, error);
        if (error) continue;
        client.hear(std::span(answer).first(bytes));
        socket.send(asio::buffer(client.hello()), 0, error);
        ++count;
    }
    return count;
}

std::uint64_t send_clocks(const Victim& victim, const std::stop_token& stop) {
    constexpr int at_once = 16;
    std::uint64_t count = 0;
    proto::Envelope message;
    while (!stop.stop_requested()) {
        Peer peer(victim);
        if (!peer.open(victim.plan)) continue;
        while (peer.connected() && !stop.stop_requested()) {
            for (int i = 0; i < at_once && peer.takes_more(); ++i) {
                message.mutable_clock()->set_time_ns(static_cast<std::int64_t>(++count));
                peer.send(message);
            }
            peer.turn();
        }
    }
    return count;
}

std::uint64_t open_and_say_bye(const Victim& victim, const std::stop_token& stop) {
    return say_byes(victim, true, stop);
}

std::uint64_t say_bye_first(const Victim& victim, const std::stop_token& stop) {
    return say_byes(victim, false, stop);
}

}  // namespace afferent::bench
