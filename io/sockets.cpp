#include "afferent/io/sockets.hpp"

#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <utility>

#include "afferent/io/stream_link.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::local::stream_protocol;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;

Error system_error(Error::Kind kind, const LinkAddress& address, const error_code& error) {
    return {kind, text(address) + ": " + error.message()};
}

Result<stream_protocol::endpoint> endpoint(const UnixAddress& address) {
    // One byte ends the path.
    constexpr std::size_t longest = sizeof(sockaddr_un::sun_path) - 1;
    if (address.path.empty() || address.path.size() > longest)
        return Error{Error::Kind::not_allowed, text(address) + ": the path of a Unix socket has from 1 to " +
                                                   std::to_string(longest) + " characters"};
    return stream_protocol::endpoint(address.path);
}

Result<tcp::endpoint> endpoint(const TcpAddress& address) {
    error_code error;
    const auto host = address.host == "localhost" ? asio::ip::make_address("127.0.0.1")
                                                  : asio::ip::make_address(address.host, error);
    if (error)
        return Error{Error::Kind::not_allowed,
                     text(address) + ": the host must be localhost or an address in digits"};
    if (!host.is_loopback())
        return Error{Error::Kind::not_allowed,
                     text(address) + ": leaves this machine, which only a link with keys may"};
    return tcp::endpoint(host, address.port);
}

LinkAddress address_of(const stream_protocol::endpoint& endpoint) { return UnixAddress{endpoint.path()}; }
LinkAddress address_of(const tcp::endpoint& endpoint) {
    return TcpAddress{endpoint.address().to_string(), endpoint.port()};
}

template <class Socket>
void tune(Socket& socket, const LinkOptions& options) {
    // Where the system does not take an option the link works all the same, only less promptly.
    error_code ignored;
    const auto bytes = static_cast<int>(options.kernel_buffer_bytes);
    socket.set_option(asio::socket_base::send_buffer_size(bytes), ignored);
    socket.set_option(asio::socket_base::receive_buffer_size(bytes), ignored);
    if constexpr (std::is_same_v<Socket, tcp::socket>) {
        using UserTimeout = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_USER_TIMEOUT>;
        socket.set_option(tcp::no_delay(true), ignored);
        socket.set_option(UserTimeout(static_cast<int>(options.silence_limit.count())), ignored);
    }
}

// A socket file may have been left behind by a listener that was killed. Nobody answers there; a live one
// does.
void remove_if_abandoned(asio::io_context& io, const stream_protocol::endpoint& endpoint) {
    struct stat status {};
    if (::stat(endpoint.path().c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return;
    stream_protocol::socket probe(io);
    error_code error;
    probe.connect(endpoint, error);
    if (error == asio::error::connection_refused) ::unlink(endpoint.path().c_str());
}
void remove_if_abandoned(asio::io_context&, const tcp::endpoint&) {}

void remove_file(const stream_protocol::endpoint& endpoint) { ::unlink(endpoint.path().c_str()); }
void remove_file(const tcp::endpoint&) {}

// Tells the listener when the link that it handed over is gone.
class GuardedLink final : public Link {
  public:
    GuardedLink(std::unique_ptr<Link> link, std::shared_ptr<const bool> lives)
        : link_(std::move(link)), lives_(std::move(lives)) {}

    void start(LinkCallbacks callbacks) override { link_->start(std::move(callbacks)); }
    bool send(const proto::Envelope& message) override { return link_->send(message); }
    void close() override { link_->close(); }
    std::size_t queued_bytes() const override { return link_->queued_bytes(); }
    bool ordered() const override { return link_->ordered(); }
    const LinkCounts& counts() const override { return link_->counts(); }

  private:
    std::unique_ptr<Link> link_;
    std::shared_ptr<const bool> lives_;
};

template <class Protocol>
class SocketListener final : public Listener {
  public:
    using Socket = typename Protocol::socket;

    SocketListener(typename Protocol::acceptor acceptor, const LinkOptions& options)
        : state_(std::make_shared<State>(std::move(acceptor), options)) {}
    ~SocketListener() override {
        error_code ignored;
        const auto endpoint = state_->acceptor.local_endpoint(ignored);
        state_->acceptor.close(ignored);
        remove_file(endpoint);
    }

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
        state_->on_peer = std::move(on_peer);
        accept(state_);
    }
    LinkAddress address() const override { return address_of(state_->acceptor.local_endpoint()); }
    std::uint64_t refused_peers() const override { return state_->refused; }

  private:
    // Outlives the listener by the accept that is under way.
    struct State {
        State(typename Protocol::acceptor acceptor_in, const LinkOptions& options_in)
            : acceptor(std::move(acceptor_in)), options(options_in) {}

        typename Protocol::acceptor acceptor;
        LinkOptions options;
        std::function<void(std::unique_ptr<Link>)> on_peer;
        std::weak_ptr<const bool> peer_lives;
        std::uint64_t refused = 0;
    };

    static void accept(const std::shared_ptr<State>& state) {
        state->acceptor.async_accept([state](const error_code& error, Socket socket) {
            if (!state->acceptor.is_open()) return;
            if (!error) welcome(*state, std::move(socket));
            accept(state);
        });
    }

    static void welcome(State& state, Socket socket) {
        tune(socket, state.options);
        auto link = make_stream_link(std::move(socket), state.options);
        if (!state.peer_lives.expired()) {
            ++state.refused;
            proto::Envelope refusal;
            refusal.mutable_answer()->set_refusal("another coprocessor is connected");
            link->start({[](const proto::Envelope&) {}, [](const Error&) {}, [](const Error&) {}});
            link->send(refusal);
            link->close();
            return;
        }
        const auto lives = std::make_shared<const bool>(true);
        state.peer_lives = lives;
        state.on_peer(std::make_unique<GuardedLink>(std::move(link), lives));
    }

    std::shared_ptr<State> state_;
};

template <class Protocol>
Result<std::unique_ptr<Listener>> open_at(asio::io_context& io, const LinkAddress& address,
                                          const typename Protocol::endpoint& endpoint,
                                          const LinkOptions& options) {
    remove_if_abandoned(io, endpoint);
    typename Protocol::acceptor acceptor(io);
    error_code error;
    acceptor.open(endpoint.protocol(), error);
    if (!error && std::is_same_v<Protocol, tcp>)
        acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) return system_error(Error::Kind::unreachable, address, error);
    return std::unique_ptr<Listener>(new SocketListener<Protocol>(std::move(acceptor), options));
}

template <class Protocol>
class SocketConnector final : public Connector {
  public:
    using Socket = typename Protocol::socket;

    SocketConnector(asio::io_context& io, LinkAddress address, Result<typename Protocol::endpoint> endpoint,
                    const Patience& patience, const LinkOptions& options)
        : state_(std::make_shared<State>(io, std::move(address), std::move(endpoint), patience, options)) {}
    ~SocketConnector() override { state_->call_off(); }

    void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) override {
        state_->on_link = std::move(on_link);
        state_->called_off = false;
        state_->began = Clock::now();
        state_->pause = state_->patience.first_pause;
        if (state_->endpoint)
            attempt(state_);
        else
            asio::post(state_->io, [state = state_] { report(*state, state->endpoint.error()); });
    }

  private:
    struct State {
        State(asio::io_context& io_in, LinkAddress address_in,
              Result<typename Protocol::endpoint> endpoint_in, const Patience& patience_in,
              const LinkOptions& options_in)
            : io(io_in),
              address(std::move(address_in)),
              endpoint(std::move(endpoint_in)),
              patience(patience_in),
              options(options_in),
              socket(io_in),
              timer(io_in) {}

        void call_off() {
            called_off = true;
            error_code ignored;
            socket.close(ignored);
            timer.cancel();
        }

        asio::io_context& io;
        LinkAddress address;
        Result<typename Protocol::endpoint> endpoint;
        Patience patience;
        LinkOptions options;
        Socket socket;
        asio::steady_timer timer;
        std::function<void(Result<std::unique_ptr<Link>>)> on_link;
        Clock::time_point began;
        std::chrono::milliseconds pause{};
        bool called_off = false;
    };

    static void attempt(const std::shared_ptr<State>& state) {
        state->socket = Socket(state->io);
        state->socket.async_connect(state->endpoint.value(), [state](const error_code& error) {
            if (state->called_off) return;
            if (error) return try_again(state, error);
            tune(state->socket, state->options);
            report(*state, make_stream_link(std::move(state->socket), state->options));
        });
    }

    static void try_again(const std::shared_ptr<State>& state, const error_code& reason) {
        if (Clock::now() + state->pause > state->began + state->patience.limit) {
            Error error = system_error(Error::Kind::unreachable, state->address, reason);
            error.text += " (tried for " + std::to_string(state->patience.limit.count()) + " ms)";
            return report(*state, std::move(error));
        }
        state->timer.expires_after(state->pause);
        state->pause = std::min(2 * state->pause, state->patience.longest_pause);
        state->timer.async_wait([state](const error_code&) {
            if (!state->called_off) attempt(state);
        });
    }

    static void report(State& state, Result<std::unique_ptr<Link>> result) {
        // The callback may start the next attempt.
        const auto on_link = std::exchange(state.on_link, nullptr);
        if (!state.called_off && on_link) on_link(std::move(result));
    }

    std::shared_ptr<State> state_;
};

template <class Protocol, class Address>
Result<std::unique_ptr<Listener>> open_listener(asio::io_context& io, const Address& address,
                                                const LinkOptions& options) {
    const auto found = endpoint(address);
    if (!found) return found.error();
    return open_at<Protocol>(io, address, found.value(), options);
}

}  // namespace

Result<std::unique_ptr<Listener>> open_socket_listener(asio::io_context& io, const UnixAddress& address,
                                                       const LinkOptions& options) {
    return open_listener<stream_protocol>(io, address, options);
}

Result<std::unique_ptr<Listener>> open_socket_listener(asio::io_context& io, const TcpAddress& address,
                                                       const LinkOptions& options) {
    return open_listener<tcp>(io, address, options);
}

std::unique_ptr<Connector> make_socket_connector(asio::io_context& io, const UnixAddress& address,
                                                 const Patience& patience, const LinkOptions& options) {
    return std::make_unique<SocketConnector<stream_protocol>>(io, address, endpoint(address), patience,
                                                              options);
}

std::unique_ptr<Connector> make_socket_connector(asio::io_context& io, const TcpAddress& address,
                                                 const Patience& patience, const LinkOptions& options) {
    return std::make_unique<SocketConnector<tcp>>(io, address, endpoint(address), patience, options);
}

}  // namespace afferent
