#include "afferent/io/links/stream_transport.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "afferent/io/links/connection_link.hpp"
#include "afferent/io/links/waiting_line.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;

class StreamListener final : public Listener {
  public:
    StreamListener(asio::io_context& io, LinkAddress address, std::unique_ptr<ConnectionAcceptor> acceptor,
                   const LinkOptions& options)
        : address_(std::move(address)),
          state_(std::make_shared<State>(io, options)),
          acceptor_(std::move(acceptor)) {}
    ~StreamListener() override {
        state_->on_peer = nullptr;
        state_->candidates->close();
    }

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
        const bool first = !std::exchange(state_->on_peer, std::move(on_peer));
        if (!first) return;
        acceptor_->start([state = state_](const Result<std::shared_ptr<StreamPeer>>& peer) {
            if (peer)
                wait_for_hello(state, peer.value());
            else
                ++state->refused;
        });
    }
    LinkAddress address() const override { return address_; }
    std::uint64_t refused_peers() const override { return state_->refused; }

  private:
    // Outlives the listener until the callback that destroys it has returned.
    struct State {
        State(asio::io_context& io, const LinkOptions& options)
            : alive_limit(options.alive_limit), candidates(std::make_shared<WaitingLine>(io)) {}

        std::chrono::milliseconds alive_limit;
        std::function<void(std::unique_ptr<Link>)> on_peer;  // empty: the listener is gone
        std::weak_ptr<StreamPeer> peer;                      // of the session
        std::shared_ptr<WaitingLine> candidates;
        std::uint64_t refused = 0;
    };

    static void wait_for_hello(const std::shared_ptr<State>& state,
                               const std::shared_ptr<StreamPeer>& candidate) {
        const auto place = state->candidates->enter([state, candidate] {
            ++state->refused;
            candidate->abort();
        });
        candidate->await_first(
            [state, place, weak = std::weak_ptr(candidate)](const Result<const proto::Envelope*>& first) {
                const auto kept = weak.lock();
                state->candidates->leave(place);
                if (!kept || !state->on_peer) return;
                if (first && first.value()->has_hello()) return welcome(*state, kept);
                ++state->refused;
                if (first || first.error().kind != Error::Kind::closed)
                    refuse(*kept, first ? "the first message is not a hello" : first.error().text,
                           Refusal::for_good);
            });
    }

    static void welcome(State& state, const std::shared_ptr<StreamPeer>& newcomer) {
        if (const auto peer = state.peer.lock(); peer && peer->lives()) {
            const auto silence = Clock::now() - peer->last_heard();
            if (state.alive_limit.count() == 0 || silence < state.alive_limit) {
                ++state.refused;
                return refuse(*newcomer, "another coprocessor is connected", Refusal::for_now);
            }
            peer->give_way({Error::Kind::closed, "the peer has been silent for " +
                                                     std::to_string(silence / std::chrono::milliseconds(1)) +
                                                     " ms, and another has taken its place"});
        }
        state.peer = newcomer;
        // The callback may be replaced, or destroyed with the listener, while it runs.
        const auto on_peer = state.on_peer;
        if (on_peer) on_peer(std::make_unique<ConnectionLink>(newcomer));
    }

    LinkAddress address_;
    std::shared_ptr<State> state_;
    std::unique_ptr<ConnectionAcceptor> acceptor_;
};

class StreamConnector final : public Connector {
  public:
    StreamConnector(asio::io_context& io, const LinkAddress& address,
                    Result<std::unique_ptr<ConnectionAttempt>> attempt, const Patience& patience)
        : state_(std::make_shared<State>(io, address, std::move(attempt), patience)) {}
    ~StreamConnector() override {
        state_->on_link = nullptr;
        state_->timer.cancel();
        if (state_->attempt) state_->attempt.value()->call_off();
    }

    void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) override {
        state_->on_link = std::move(on_link);
        state_->began = Clock::now();
        state_->pause = state_->patience.first_pause;
        if (state_->attempt) return try_once(state_);
        asio::post(state_->io, [state = state_] { report(*state, state->attempt.error()); });
    }

  private:
    struct State {
        State(asio::io_context& io_in, LinkAddress address_in,
              Result<std::unique_ptr<ConnectionAttempt>> attempt_in, const Patience& patience_in)
            : io(io_in),
              address(std::move(address_in)),
              attempt(std::move(attempt_in)),
              patience(patience_in),
              timer(io_in) {}

        asio::io_context& io;
        LinkAddress address;
        Result<std::unique_ptr<ConnectionAttempt>> attempt;
        Patience patience;
        asio::steady_timer timer;
        std::function<void(Result<std::unique_ptr<Link>>)> on_link;  // empty: nobody waits for an outcome
        Clock::time_point began;
        std::chrono::milliseconds pause{};
    };

    static void try_once(const std::shared_ptr<State>& state) {
        state->attempt.value()->start(
            [weak = std::weak_ptr(state)](const Result<std::shared_ptr<StreamPeer>>& connection) {
                const auto kept = weak.lock();
                if (!kept || !kept->on_link) return;
                if (connection)
                    report(*kept, std::unique_ptr<Link>(new ConnectionLink(connection.value())));
                else
                    failed(kept, connection.error());
            });
    }

    static void failed(const std::shared_ptr<State>& state, const Error& reason) {
        Error error{reason.kind, text(state->address) + ": " + reason.text};
        if (reason.kind == Error::Kind::not_allowed) return report(*state, std::move(error));
        if (Clock::now() + state->pause > state->began + state->patience.limit) {
            error.text += " (tried for " + std::to_string(state->patience.limit.count()) + " ms)";
            return report(*state, std::move(error));
        }
        state->timer.expires_after(state->pause);
        state->pause = std::min(2 * state->pause, state->patience.longest_pause);
        state->timer.async_wait([weak = std::weak_ptr(state)](const boost::system::error_code&) {
            const auto kept = weak.lock();
            if (kept && kept->on_link) try_once(kept);
        });
    }

    static void report(State& state, Result<std::unique_ptr<Link>> result) {
        // The callback may start the next attempt.
        const auto on_link = std::exchange(state.on_link, nullptr);
        if (on_link) on_link(std::move(result));
    }

    std::shared_ptr<State> state_;
};

}  // namespace

void refuse(StreamPeer& peer, const std::string& text, Refusal refusal) {
    proto::Envelope message;
    message.mutable_answer()->set_refusal(text);
    message.mutable_answer()->set_busy(refusal == Refusal::for_now);
    peer.send(message);
    peer.close();
}

std::unique_ptr<Listener> make_stream_listener(asio::io_context& io, const LinkAddress& address,
                                               std::unique_ptr<ConnectionAcceptor> acceptor,
                                               const LinkOptions& options) {
    return std::make_unique<StreamListener>(io, address, std::move(acceptor), options);
}

std::unique_ptr<Connector> make_stream_connector(asio::io_context& io, const LinkAddress& address,
                                                 Result<std::unique_ptr<ConnectionAttempt>> attempt,
                                                 const Patience& patience) {
    return std::make_unique<StreamConnector>(io, address, std::move(attempt), patience);
}

}  // namespace afferent
