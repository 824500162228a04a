#include "afferent/io/links/socket_transport.hpp"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "afferent/io/links/endpoints.hpp"
#include "afferent/io/links/waiting_line.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

class SocketAcceptor final : public ConnectionAcceptor {
  public:
    SocketAcceptor(std::shared_ptr<StreamAcceptor> acceptor, Secure secure, std::optional<SocketFile> file,
                   const LinkOptions& options)
        : file_(std::move(file)),
          state_(std::make_shared<State>(std::move(acceptor), std::move(secure), options)) {}
    ~SocketAcceptor() override {
        // While the socket is bound, no other file can have its inode.
        file_.reset();
        error_code ignored;
        state_->acceptor->close(ignored);
        state_->line->close();
    }
    SocketAcceptor(const SocketAcceptor&) = delete;
    SocketAcceptor& operator=(const SocketAcceptor&) = delete;

    void start(OnStreamPeer on_peer) override {
        state_->on_peer = std::move(on_peer);
        accept_each(state_->acceptor,
                    [state = state_](StreamSocket socket) { secure(state, std::move(socket)); });
    }

  private:
    // Outlives the acceptor until the operation under way has ended.
    struct State {
        State(std::shared_ptr<StreamAcceptor> acceptor_in, Secure secure_in, const LinkOptions& options_in)
            : acceptor(std::move(acceptor_in)),
              secure(std::move(secure_in)),
              options(options_in),
              line(std::make_shared<WaitingLine>(acceptor->get_executor())) {}

        std::shared_ptr<StreamAcceptor> acceptor;
        Secure secure;
        LinkOptions options;
        OnStreamPeer on_peer;
        std::shared_ptr<WaitingLine> line;  // of those whose connections are being secured
    };

    static void secure(const std::shared_ptr<State>& state, StreamSocket socket) {
        tune(socket, state->options);
        const auto call_off = std::make_shared<std::function<void()>>();
        const auto place = state->line->enter([call_off] {
            if (*call_off) (*call_off)();
        });
        state->secure(std::move(socket), StreamRole::listens, call_off,
                      [state, place](const Result<std::shared_ptr<StreamPeer>>& peer) {
                          state->line->leave(place);
                          if (state->acceptor->is_open()) state->on_peer(peer);
                      });
    }

    std::optional<SocketFile> file_;  // of a Unix socket
    std::shared_ptr<State> state_;
};

class SocketAttempt final : public ConnectionAttempt {
  public:
    SocketAttempt(asio::io_context& io, const StreamEndpoint& endpoint, Secure secure,
                  const LinkOptions& options, std::chrono::milliseconds limit)
        : state_(std::make_shared<State>(io, endpoint, std::move(secure), options)), limit_(limit) {}
    ~SocketAttempt() override { call_off(); }
    SocketAttempt(const SocketAttempt&) = delete;
    SocketAttempt& operator=(const SocketAttempt&) = delete;

    void start(OnStreamPeer on_peer) override {
        state_->on_peer = std::move(on_peer);
        state_->socket = StreamSocket(state_->socket.get_executor());
        // The system's own timeout is minutes.
        state_->timer.expires_after(limit_);
        state_->timer.async_wait([weak = std::weak_ptr(state_), limit = limit_](const error_code& error) {
            const auto state = weak.lock();
            if (error || !state || !state->on_peer) return;
            stop(*state);
            report(*state, Error{Error::Kind::unreachable,
                                 "no answer within " + std::to_string(limit.count()) + " ms"});
        });
        state_->socket.async_connect(state_->endpoint, [state = state_](const error_code& error) {
            if (!state->on_peer || error == asio::error::operation_aborted) return;
            if (error) return report(*state, Error{Error::Kind::unreachable, error.message()});
            tune(state->socket, state->options);
            state->secure(std::move(state->socket), StreamRole::connects, state->call_off,
                          [state](const Result<std::shared_ptr<StreamPeer>>& peer) {
                              *state->call_off = nullptr;
                              report(*state, peer);
                          });
        });
    }

    void call_off() override {
        state_->on_peer = nullptr;
        state_->timer.cancel();
        stop(*state_);
    }

  private:
    struct State {
        State(asio::io_context& io, const StreamEndpoint& endpoint_in, Secure secure_in,
              const LinkOptions& options_in)
            : endpoint(endpoint_in),
              secure(std::move(secure_in)),
              options(options_in),
              socket(io),
              timer(io) {}

        StreamEndpoint endpoint;
        Secure secure;
        LinkOptions options;
        StreamSocket socket;
        asio::steady_timer timer;
        OnStreamPeer on_peer;  // empty: called off, or over
        CallOff call_off = std::make_shared<std::function<void()>>();
    };

    static void stop(State& state) {
        error_code ignored;
        state.socket.close(ignored);
        if (const auto call_off = std::exchange(*state.call_off, nullptr)) call_off();
    }

    static void report(State& state, const Result<std::shared_ptr<StreamPeer>>& peer) {
        state.timer.cancel();
        const auto on_peer = std::exchange(state.on_peer, nullptr);
        if (on_peer) on_peer(peer);
    }

    std::shared_ptr<State> state_;
    std::chrono::milliseconds limit_;
};

}  // namespace

Result<std::unique_ptr<Listener>> open_socket_listener(asio::io_context& io, const LinkAddress& address,
                                                       const StreamEndpoint& endpoint, Secure secure,
                                                       const LinkOptions& options) {
    const auto acceptor = std::make_shared<StreamAcceptor>(io);
    if (const error_code error = listen(*acceptor, endpoint))
        return system_error(Error::Kind::unreachable, address, error);
    std::optional<SocketFile> file;
    if (const auto* const local = std::get_if<UnixAddress>(&address)) file.emplace(local->path);
    return make_stream_listener(
        io, bound_address(*acceptor, address),
        std::make_unique<SocketAcceptor>(acceptor, std::move(secure), std::move(file), options), options);
}

std::unique_ptr<ConnectionAttempt> make_socket_attempt(asio::io_context& io, const StreamEndpoint& endpoint,
                                                       Secure secure, const LinkOptions& options,
                                                       std::chrono::milliseconds limit) {
    return std::make_unique<SocketAttempt>(io, endpoint, std::move(secure), options, limit);
}

void tune(StreamSocket& socket, const LinkOptions& options) {
    using UserTimeout = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_USER_TIMEOUT>;
    // Where the system does not take an option the link works all the same, only less promptly.
    error_code ignored;
    const auto bytes = static_cast<int>(options.kernel_buffer_bytes);
    socket.set_option(asio::socket_base::send_buffer_size(bytes), ignored);
    socket.set_option(asio::socket_base::receive_buffer_size(bytes), ignored);
    socket.set_option(asio::ip::tcp::no_delay(true), ignored);
    socket.set_option(UserTimeout(static_cast<int>(options.silence_limit.count())), ignored);
}

}  // namespace afferent
