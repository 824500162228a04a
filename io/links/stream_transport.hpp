// Listeners and connectors over sockets that carry streams. For the transports; programs use transports.hpp.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "afferent/io/links/acceptor.hpp"
#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"
#include "afferent/io/links/stream_link.hpp"

namespace afferent {

// A socket file may have been left behind by a listener that was killed. Nobody answers there; a live one
// does.
void remove_if_abandoned(boost::asio::io_context& io, const std::string& path);

// Small buffers, no delay, a limit on how long the peer may leave bytes unacknowledged.
void tune(boost::asio::ip::tcp::socket& socket, const LinkOptions& options);
void tune(boost::asio::local::stream_protocol::socket& socket, const LinkOptions& options);

inline Error system_error(Error::Kind kind, const LinkAddress& address,
                          const boost::system::error_code& error) {
    return {kind, text(address) + ": " + error.message()};
}

enum class StreamRole { listens, connects };

// What stands between a connection and its link: here, nothing.
template <class Socket>
struct Unsecured {
    using Stream = Socket;

    // Whoever begins may call it off by `call_off`, where it takes time; it is done then all the same, with
    // an error.
    template <class Done>
    void operator()(Socket socket, StreamRole, std::function<void()>&, Done done) const {
        done(boost::system::error_code(), std::move(socket));
    }
    // Whether another attempt could not end otherwise.
    static bool is_final(const boost::system::error_code&) { return false; }
    static std::string words(const boost::system::error_code& error) { return error.message(); }
};

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

// One peer at a time; what else connects is refused in words, once it has secured its stream.
template <class Protocol, class Securing>
class StreamListener final : public Listener {
  public:
    using Socket = typename Protocol::socket;
    using Stream = typename Securing::Stream;
    // The address as the endpoint has it, with the port that was found.
    using Named = std::function<LinkAddress(const typename Protocol::endpoint&)>;

    StreamListener(typename Protocol::acceptor acceptor, Securing securing, Named named,
                   const LinkOptions& options)
        : state_(std::make_shared<State>(std::move(acceptor), std::move(securing), options)),
          named_(std::move(named)) {}
    ~StreamListener() override {
        boost::system::error_code ignored;
        const auto endpoint = state_->acceptor.local_endpoint(ignored);
        state_->acceptor.close(ignored);
        if constexpr (std::is_same_v<Protocol, boost::asio::local::stream_protocol>)
            ::unlink(endpoint.path().c_str());
    }

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
        state_->on_peer = std::move(on_peer);
        accept_each(state_, &StreamListener::secure);
    }
    LinkAddress address() const override { return named_(state_->acceptor.local_endpoint()); }
    std::uint64_t refused_peers() const override { return state_->refused; }

  private:
    // Outlives the listener by the accept that is under way.
    struct State {
        State(typename Protocol::acceptor acceptor_in, Securing securing_in, const LinkOptions& options_in)
            : acceptor(std::move(acceptor_in)), securing(std::move(securing_in)), options(options_in) {}

        typename Protocol::acceptor acceptor;
        Securing securing;
        LinkOptions options;
        std::uint64_t begun = 0;
        std::map<std::uint64_t, std::function<void()>> securing_now;  // each calls one off; the oldest first
        std::function<void(std::unique_ptr<Link>)> on_peer;
        std::weak_ptr<const bool> peer_lives;
        std::uint64_t refused = 0;
    };

    static void secure(const std::shared_ptr<State>& state, Socket socket) {
        // The oldest gives way: those who only connect, and prove nothing, cannot keep the door shut.
        if (state->securing_now.size() == most_securing_at_once) {
            state->securing_now.begin()->second();
            state->securing_now.erase(state->securing_now.begin());
        }
        const std::uint64_t number = state->begun++;
        tune(socket, state->options);
        state->securing(std::move(socket), StreamRole::listens, state->securing_now[number],
                        [state, number](const boost::system::error_code& error, Stream stream) {
                            state->securing_now.erase(number);
                            if (!state->acceptor.is_open()) return;
                            if (error) return void(++state->refused);
                            welcome(*state, std::move(stream));
                        });
    }

    static void welcome(State& state, Stream stream) {
        auto link = make_stream_link(std::move(stream), state.options);
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

    static constexpr std::size_t most_securing_at_once = 64;

    std::shared_ptr<State> state_;
    Named named_;
};

// `named` gives the address of the listener's endpoint.
template <class Protocol, class Securing>
Result<std::unique_ptr<Listener>> open_stream_listener(
    boost::asio::io_context& io, const LinkAddress& address, const typename Protocol::endpoint& endpoint,
    Securing securing, typename StreamListener<Protocol, Securing>::Named named, const LinkOptions& options) {
    typename Protocol::acceptor acceptor(io);
    if (const boost::system::error_code error = listen<Protocol>(acceptor, endpoint))
        return system_error(Error::Kind::unreachable, address, error);
    return std::unique_ptr<Listener>(new StreamListener<Protocol, Securing>(
        std::move(acceptor), std::move(securing), std::move(named), options));
}

template <class Protocol, class Securing>
class StreamConnector final : public Connector {
  public:
    using Socket = typename Protocol::socket;
    using Stream = typename Securing::Stream;

    // Without a good endpoint, or a way to secure it, every start reports why.
    StreamConnector(boost::asio::io_context& io, LinkAddress address,
                    Result<typename Protocol::endpoint> endpoint, Result<Securing> securing,
                    const Patience& patience, const LinkOptions& options)
        : state_(std::make_shared<State>(io, std::move(address), std::move(endpoint), std::move(securing),
                                         patience, options)) {}
    ~StreamConnector() override { state_->call_off(); }

    void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) override {
        state_->on_link = std::move(on_link);
        state_->called_off = false;
        state_->began = std::chrono::steady_clock::now();
        state_->pause = state_->patience.first_pause;
        if (state_->endpoint && state_->securing) return attempt(state_);
        boost::asio::post(state_->io, [state = state_] {
            report(*state, state->endpoint ? state->securing.error() : state->endpoint.error());
        });
    }

  private:
    struct State {
        State(boost::asio::io_context& io_in, LinkAddress address_in,
              Result<typename Protocol::endpoint> endpoint_in, Result<Securing> securing_in,
              const Patience& patience_in, const LinkOptions& options_in)
            : io(io_in),
              address(std::move(address_in)),
              endpoint(std::move(endpoint_in)),
              securing(std::move(securing_in)),
              patience(patience_in),
              options(options_in),
              socket(io_in),
              timer(io_in) {}

        void call_off() {
            called_off = true;
            boost::system::error_code ignored;
            socket.close(ignored);
            timer.cancel();
            if (const auto securing_now = std::exchange(call_off_securing, nullptr)) securing_now();
        }

        boost::asio::io_context& io;
        LinkAddress address;
        Result<typename Protocol::endpoint> endpoint;
        Result<Securing> securing;
        Patience patience;
        LinkOptions options;
        Socket socket;
        boost::asio::steady_timer timer;
        std::function<void(Result<std::unique_ptr<Link>>)> on_link;
        std::chrono::steady_clock::time_point began;
        std::chrono::milliseconds pause{};
        std::function<void()> call_off_securing;
        bool called_off = false;
    };

    static void attempt(const std::shared_ptr<State>& state) {
        state->socket = Socket(state->io);
        state->socket.async_connect(state->endpoint.value(), [state](const boost::system::error_code& error) {
            if (state->called_off) return;
            if (error) return try_again(state, error);
            tune(state->socket, state->options);
            state->securing.value()(std::move(state->socket), StreamRole::connects, state->call_off_securing,
                                    [state](const boost::system::error_code& failure, Stream stream) {
                                        secured(state, failure, std::move(stream));
                                    });
        });
    }

    static void secured(const std::shared_ptr<State>& state, const boost::system::error_code& error,
                        Stream stream) {
        state->call_off_securing = nullptr;
        if (state->called_off) return;
        if (Securing::is_final(error))
            return report(*state, Error{Error::Kind::not_allowed,
                                        text(state->address) + ": " + Securing::words(error)});
        if (error) return try_again(state, error);
        report(*state, make_stream_link(std::move(stream), state->options));
    }

    static void try_again(const std::shared_ptr<State>& state, const boost::system::error_code& reason) {
        if (std::chrono::steady_clock::now() + state->pause > state->began + state->patience.limit) {
            Error error = system_error(Error::Kind::unreachable, state->address, reason);
            error.text += " (tried for " + std::to_string(state->patience.limit.count()) + " ms)";
            return report(*state, std::move(error));
        }
        state->timer.expires_after(state->pause);
        state->pause = std::min(2 * state->pause, state->patience.longest_pause);
        state->timer.async_wait([state](const boost::system::error_code&) {
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

}  // namespace afferent
