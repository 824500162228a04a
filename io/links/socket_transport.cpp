#include "afferent/io/links/socket_transport.hpp"

#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "afferent/io/links/endpoints.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

class SocketAcceptor final : public ConnectionAcceptor {
  public:
    SocketAcceptor(std::shared_ptr<StreamAcceptor> acceptor, Secure secure, std::string file,
                   const LinkOptions& options)
        : state_(std::make_shared<State>(std::move(acceptor), std::move(secure), options)),
          file_(std::move(file)) {}
    ~SocketAcceptor() override {
        error_code ignored;
        state_->acceptor->close(ignored);
        if (!file_.empty()) ::unlink(file_.c_str());
    }
    SocketAcceptor(const SocketAcceptor&) = delete;
    SocketAcceptor& operator=(const SocketAcceptor&) = delete;

    void start(OnConnection on_peer) override {
        state_->on_peer = std::move(on_peer);
        accept_each(state_->acceptor,
                    [state = state_](StreamSocket socket) { secure(state, std::move(socket)); });
    }

  private:
    // Outlives the acceptor by the operation that is under way.
    struct State {
        State(std::shared_ptr<StreamAcceptor> acceptor_in, Secure secure_in, const LinkOptions& options_in)
            : acceptor(std::move(acceptor_in)), secure(std::move(secure_in)), options(options_in) {}

        std::shared_ptr<StreamAcceptor> acceptor;
        Secure secure;
        LinkOptions options;
        OnConnection on_peer;
        std::uint64_t begun = 0;
        std::map<std::uint64_t, std::function<void()>> securing;  // each calls one off; the oldest first
    };

    static void secure(const std::shared_ptr<State>& state, StreamSocket socket) {
        // The oldest gives way, so that peers that connect and prove nothing cannot keep others out.
        if (state->securing.size() == most_securing) {
            state->securing.begin()->second();
            state->securing.erase(state->securing.begin());
        }
        const std::uint64_t number = state->begun++;
        tune(socket, state->options);
        state->secure(std::move(socket), StreamRole::listens, state->securing[number],
                      [state, number](const Result<std::shared_ptr<Connection>>& connection) {
                          state->securing.erase(number);
                          if (state->acceptor->is_open()) state->on_peer(connection);
                      });
    }

    static constexpr std::size_t most_securing = 64;

    std::shared_ptr<State> state_;
    std::string file_;  // of a Unix socket
};

class SocketAttempt final : public ConnectionAttempt {
  public:
    SocketAttempt(asio::io_context& io, const StreamEndpoint& endpoint, Secure secure,
                  const LinkOptions& options)
        : state_(std::make_shared<State>(io, endpoint, std::move(secure), options)) {}
    ~SocketAttempt() override { call_off(); }
    SocketAttempt(const SocketAttempt&) = delete;
    SocketAttempt& operator=(const SocketAttempt&) = delete;

    void start(OnConnection on_connection) override {
        state_->on_connection = std::move(on_connection);
        state_->socket = StreamSocket(state_->socket.get_executor());
        state_->socket.async_connect(state_->endpoint, [state = state_](const error_code& error) {
            if (!state->on_connection) return;
            if (error) return report(*state, Error{Error::Kind::unreachable, error.message()});
            tune(state->socket, state->options);
            state->secure(std::move(state->socket), StreamRole::connects, state->call_off,
                          [state](const Result<std::shared_ptr<Connection>>& connection) {
                              state->call_off = nullptr;
                              report(*state, connection);
                          });
        });
    }

    void call_off() override {
        state_->on_connection = nullptr;
        error_code ignored;
        state_->socket.close(ignored);
        if (const auto call_off = std::exchange(state_->call_off, nullptr)) call_off();
    }

  private:
    struct State {
        State(asio::io_context& io, const StreamEndpoint& endpoint_in, Secure secure_in,
              const LinkOptions& options_in)
            : endpoint(endpoint_in), secure(std::move(secure_in)), options(options_in), socket(io) {}

        StreamEndpoint endpoint;
        Secure secure;
        LinkOptions options;
        StreamSocket socket;
        OnConnection on_connection;  // empty: called off
        std::function<void()> call_off;
    };

    static void report(State& state, const Result<std::shared_ptr<Connection>>& connection) {
        const auto on_connection = std::exchange(state.on_connection, nullptr);
        if (on_connection) on_connection(connection);
    }

    std::shared_ptr<State> state_;
};

}  // namespace

Result<std::unique_ptr<Listener>> open_socket_listener(asio::io_context& io, const LinkAddress& address,
                                                       const StreamEndpoint& endpoint, Secure secure,
                                                       const LinkOptions& options) {
    const auto acceptor = std::make_shared<StreamAcceptor>(io);
    if (const error_code error = listen(*acceptor, endpoint))
        return system_error(Error::Kind::unreachable, address, error);
    const auto* const local = std::get_if<UnixAddress>(&address);
    return make_stream_listener(
        bound_address(*acceptor, address),
        std::make_unique<SocketAcceptor>(acceptor, std::move(secure), local ? local->path : "", options));
}

std::unique_ptr<ConnectionAttempt> make_socket_attempt(asio::io_context& io, const StreamEndpoint& endpoint,
                                                       Secure secure, const LinkOptions& options) {
    return std::make_unique<SocketAttempt>(io, endpoint, std::move(secure), options);
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
