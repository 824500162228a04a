// A network in memory with any fault that is asked for. It knows what really reaches the hand.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {

// As a session sees it: a stream is complete and in order, or broken; datagrams may be lost, doubled and
// overtaken, and an end does not see the other one go.
enum class NetworkKind { stream, datagrams };

class FaultyNetwork {
  public:
    enum Side : std::size_t { hand, coprocessor };

    struct Fate {
        unsigned copies = 1;
        Duration delay{};
    };

    FaultyNetwork(MonotonicClock clock, NetworkKind kind) : clock_(std::move(clock)), kind_(kind) {}

    // The fate of every message on its way to that end. A stream loses packets only, in the sender's queue.
    std::function<Fate(const proto::Envelope&, Side)> fate = [](const auto&, Side) { return Fate{}; };
    // A message of the hand's own coprocessor is about to be handed to the hand for the first time.
    // `overtaken`: for how long one that was sent after it has been there.
    std::function<void(const proto::Envelope&, Duration transit, Duration overtaken)> to_hand =
        [](const auto&, Duration, Duration) {};

    // The peers of a stranger's connector are hostile: what they send is not reported to `to_hand`.
    std::unique_ptr<Listener> listener() { return std::make_unique<OneListener>(*this); }
    std::unique_ptr<Connector> connector(bool hostile = false) {
        return std::make_unique<OneConnector>(*this, hostile);
    }

    // Stops a process: messages for it wait.
    void stop(Side link_end, bool stopped) { stopped_[link_end] = stopped; }
    // Pulls the cable: a stream keeps everything for later, datagrams are lost.
    void cut(bool is_cut) { cut_ = is_cut; }

    // Sends to the hand, as if from the peer that it has at present. Without a message, a bad frame.
    void inject(std::optional<proto::Envelope> message) {
        if (const auto end = accepted_.lock(); end && !end->closed && end->callbacks.message)
            carry(*end, {.to = end, .sent = clock_(), .hostile = true, .message = std::move(message)}, {});
    }

    // Hands over what has arrived; true if there was anything.
    bool deliver() {
        bool any = attempt();
        for (const Side link_end : {hand, coprocessor}) {
            auto& queue = under_way_[link_end];
            while (!stopped_[link_end] && !queue.empty() && queue.begin()->first <= clock_() &&
                   !(cut_ && kind_ == NetworkKind::stream)) {
                const Parcel parcel = std::move(queue.begin()->second);
                queue.erase(queue.begin());
                hand_over(parcel);
                any = true;
            }
        }
        give_up_on_silent_peers();
        return any;
    }
    std::optional<MonotonicTime> next_arrival() const {
        std::optional<MonotonicTime> next;
        if (!attempts_.empty()) next = attempts_.begin()->first;
        if (cut_ && kind_ == NetworkKind::stream) return next;
        for (const Side link_end : {hand, coprocessor})
            if (!stopped_[link_end] && !under_way_[link_end].empty())
                next = std::min(next.value_or(MonotonicTime::max()), under_way_[link_end].begin()->first);
        return next;
    }

  private:
    static constexpr Duration alive = 150ms;  // a peer that has said something within this keeps its place
    static constexpr Duration patience = 1s;  // with a datagram peer that says nothing
    static constexpr std::size_t most_remembered = 1000;

    struct End {
        Side link_end{};
        bool hostile = false;
        LinkCallbacks callbacks = {};
        std::weak_ptr<End> peer = {};
        bool closed = false;
        MonotonicTime last_heard{};
        std::uint64_t sent = 0;
        std::map<std::uint64_t, MonotonicTime> came = {};  // the latest packets, by the order of sending
        LinkCounts counts = {};
    };

    struct Parcel {
        std::weak_ptr<End> to = {};
        MonotonicTime sent{};
        std::uint64_t number = 0;
        bool hostile = false;
        bool closing = false;
        std::optional<proto::Envelope> message = {};
    };

    class EndLink final : public Link {
      public:
        EndLink(FaultyNetwork& network, std::shared_ptr<End> end) : network_(network), end_(std::move(end)) {}
        ~EndLink() override { close(); }
        void start(LinkCallbacks callbacks) override { end_->callbacks = std::move(callbacks); }
        bool send(const proto::Envelope& message) override {
            return end_->closed || network_.send(*end_, message);
        }
        void close() override { network_.close(*end_); }
        std::size_t queued_bytes() const override { return 0; }
        bool ordered() const override { return network_.kind_ == NetworkKind::stream; }
        const LinkCounts& counts() const override { return end_->counts; }

      private:
        FaultyNetwork& network_;
        std::shared_ptr<End> end_;
    };

    class OneListener final : public Listener {
      public:
        explicit OneListener(FaultyNetwork& network) : network_(network) {}
        ~OneListener() override { network_.on_peer_ = nullptr; }
        void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
            network_.on_peer_ = std::move(on_peer);
        }
        LinkAddress address() const override { return UnixAddress{"in memory"}; }
        std::uint64_t refused_peers() const override { return network_.refused_peers_; }

      private:
        FaultyNetwork& network_;
    };

    class OneConnector final : public Connector {
      public:
        OneConnector(FaultyNetwork& network, bool hostile) : network_(network), hostile_(hostile) {}
        void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) override {
            on_link_ = std::move(on_link);
            give_up_at_ = network_.clock_() + 5s;
            attempt_at(network_.clock_());
        }

      private:
        void attempt_at(MonotonicTime time) {
            network_.attempts_.emplace(time, [this, life = std::weak_ptr<int>(life_)] {
                if (life.lock()) attempt();
            });
        }
        void attempt() {
            if (network_.cut_ || network_.stopped_[hand] || !network_.on_peer_) {
                if (network_.clock_() < give_up_at_) return attempt_at(network_.clock_() + 20ms);
                return std::exchange(on_link_, {})(Error{Error::Kind::unreachable, "nobody listens"});
            }
            network_.connect(hostile_, std::exchange(on_link_, {}));
        }

        FaultyNetwork& network_;
        bool hostile_;
        MonotonicTime give_up_at_{};
        std::function<void(Result<std::unique_ptr<Link>>)> on_link_;
        std::shared_ptr<int> life_ = std::make_shared<int>();
    };

    void connect(bool hostile, const std::function<void(Result<std::unique_ptr<Link>>)>& on_link) {
        const auto theirs = std::make_shared<End>(End{.link_end = coprocessor, .last_heard = clock_()});
        const auto ours =
            std::make_shared<End>(End{.link_end = hand, .hostile = hostile, .last_heard = clock_()});
        theirs->peer = ours;
        ours->peer = theirs;
        auto listening = std::make_unique<EndLink>(*this, ours);
        ends_.push_back(theirs);
        ends_.push_back(ours);
        on_link(std::unique_ptr<Link>(std::make_unique<EndLink>(*this, theirs)));
        const auto before = accepted_.lock();
        if (before && !before->closed && clock_() - before->last_heard < alive) {
            ++refused_peers_;
            return;  // which closes the connection
        }
        if (before) break_off(*before, "another peer has come");
        accepted_ = ours;
        on_peer_(std::move(listening));
    }

    bool send(End& from, const proto::Envelope& message) {
        const auto to = from.peer.lock();
        if (!to) return true;
        Fate becomes = fate(message, to->link_end);
        const bool stream = kind_ == NetworkKind::stream;
        const bool lost = becomes.copies == 0 || (cut_ && !stream);
        ++from.sent;
        if (lost && (!stream || is_packet(message))) {
            if (stream) ++from.counts.dropped;
            return !stream;
        }
        for (unsigned copy = 0; copy < (stream ? 1U : becomes.copies); ++copy) {
            carry(
                *to,
                {.to = to, .sent = clock_(), .number = from.sent, .hostile = to->hostile, .message = message},
                becomes.delay);
            becomes.delay = {};
        }
        return true;
    }

    void close(End& end) {
        if (std::exchange(end.closed, true) || kind_ == NetworkKind::datagrams) return;
        if (const auto peer = end.peer.lock())
            carry(*peer, {.to = peer, .sent = clock_(), .closing = true}, {});
    }

    void carry(const End& to, Parcel parcel, Duration delay) {
        MonotonicTime arrives = clock_() + delay;
        if (kind_ == NetworkKind::stream)
            arrives = last_arrival_[to.link_end] = std::max(last_arrival_[to.link_end], arrives);
        under_way_[to.link_end].emplace(arrives, std::move(parcel));
    }

    void hand_over(const Parcel& parcel) {
        const auto end = parcel.to.lock();
        if (!end || end->closed || !end->callbacks.message) return;
        if (parcel.closing) return break_off(*end, "the peer has gone");
        if (!parcel.message) return end->callbacks.bad_frame({Error::Kind::malformed, "not a message"});
        end->last_heard = clock_();
        if (end->link_end == hand && !parcel.hostile && !end->came.contains(parcel.number)) {
            const auto overtaking = end->came.upper_bound(parcel.number);
            Duration overtaken{};
            for (auto later = overtaking; later != end->came.end(); ++later)
                overtaken = std::max<Duration>(overtaken, clock_() - later->second);
            to_hand(*parcel.message, clock_() - parcel.sent, overtaken);
        }
        if (is_packet(*parcel.message)) end->came.emplace(parcel.number, clock_());
        if (end->came.size() > most_remembered) end->came.erase(end->came.begin());
        ++end->counts.in.frames;
        end->callbacks.message(*parcel.message);
    }

    static void break_off(End& end, const char* why) {
        if (std::exchange(end.closed, true) || !end.callbacks.closed) return;
        // It may destroy the link, and with it the callback.
        const auto closed = end.callbacks.closed;
        closed({Error::Kind::closed, why});
    }

    // To connect, wherever that is due.
    bool attempt() {
        bool any = false;
        for (; !attempts_.empty() && attempts_.begin()->first <= clock_(); any = true) {
            const auto due = std::move(attempts_.begin()->second);
            attempts_.erase(attempts_.begin());
            due();
        }
        return any;
    }

    void give_up_on_silent_peers() {
        std::erase_if(ends_, [](const auto& end) { return end.expired(); });
        if (kind_ == NetworkKind::stream) return;
        const auto ends = ends_;
        for (const auto& known : ends)
            if (const auto end = known.lock();
                end && !stopped_[end->link_end] && clock_() - end->last_heard > patience)
                break_off(*end, "the peer is silent");
    }

    MonotonicClock clock_;
    NetworkKind kind_;
    std::function<void(std::unique_ptr<Link>)> on_peer_;
    std::weak_ptr<End> accepted_;
    std::vector<std::weak_ptr<End>> ends_;
    std::array<std::multimap<MonotonicTime, Parcel>, 2> under_way_;
    std::array<MonotonicTime, 2> last_arrival_{};
    std::multimap<MonotonicTime, std::function<void()>> attempts_;
    std::array<bool, 2> stopped_{};
    bool cut_ = false;
    std::uint64_t refused_peers_ = 0;
};

}  // namespace afferent
