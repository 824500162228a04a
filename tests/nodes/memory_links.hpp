// Links between nodes of one program, on a clock of its own: what one end sends is handed to the other, with
// no system in between. For tests in virtual time.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {

// One listener and any number of connectors. Their links are ordered, and live on without this.
//
//     MemoryLinks links(clock);
//     auto hand = HandNode::open(scene, links.listener(), ...);
//     auto coprocessor = CoprocessorNode::open(scene, links.connector(), ...);
//     ...  links.deliver();  hand->poll();  coprocessor->poll();
class MemoryLinks {
  public:
    explicit MemoryLinks(MonotonicClock clock);

    std::unique_ptr<Listener> listener();
    std::unique_ptr<Connector> connector(const Patience& patience = {});

    // The latency of everything sent from now on. Nothing overtakes what was sent before.
    void set_latency(std::chrono::nanoseconds latency);
    // Asked for every message, and with null for the news that an end has closed. False: it is lost without a
    // trace at either end.
    void set_carries(std::function<bool(const proto::Envelope*)> carries);
    // What each link says is queued, in place of what is under way.
    void set_queued_bytes(std::size_t bytes);

    // Hands over what has arrived by now; all callbacks come from here. Returns whether there was anything.
    bool deliver();
    // When the next thing arrives; nothing if nothing is under way.
    std::optional<MonotonicTime> next_arrival() const;

  private:
    struct End;
    struct Network;
    class EndLink;
    class MemoryListener;
    class MemoryConnector;

    std::shared_ptr<Network> network_;
};

// One end of a link, alive as long as its owner.
struct MemoryLinks::End : std::enable_shared_from_this<End> {
    LinkCallbacks callbacks;
    std::weak_ptr<End> peer;
    bool closed = false;
    LinkCounts counts;
    std::size_t under_way_bytes = 0;  // sent, and not handed over yet
    FrameWriter writer;               // for the length of what is sent
};

struct MemoryLinks::Network : std::enable_shared_from_this<Network> {
    MonotonicClock clock;
    std::chrono::nanoseconds latency{};
    std::function<bool(const proto::Envelope*)> carries = [](const auto*) { return true; };
    std::optional<std::size_t> queued_bytes;
    std::multimap<MonotonicTime, std::function<void()>>
        under_way;  // what arrives together: in order of sending
    MonotonicTime last_arrival{};
    std::function<void(std::unique_ptr<Link>)> on_peer;  // empty: nobody listens
    std::weak_ptr<End> accepted;
    std::uint64_t refused_peers = 0;

    void at(MonotonicTime time, std::function<void()> deliver) {
        under_way.emplace(time, std::move(deliver));
    }

    void carry(std::function<void()> deliver) {
        last_arrival = std::max(last_arrival, clock() + latency);
        at(last_arrival, std::move(deliver));
    }

    void send(End& from, const proto::Envelope& message) {
        const std::size_t bytes = from.writer.stream_frame(message).size();
        from.counts.bytes_out += bytes;
        if (!carries(&message)) return;
        from.under_way_bytes += bytes;
        carry([from = from.weak_from_this(), to = from.peer, message, bytes] {
            if (const auto sender = from.lock()) sender->under_way_bytes -= bytes;
            const auto end = to.lock();
            if (!end || end->closed) return;
            end->counts.in.bytes += bytes;
            ++end->counts.in.frames;
            end->callbacks.message(message);
        });
    }

    void close(End& end) {
        if (std::exchange(end.closed, true) || !carries(nullptr)) return;
        carry([to = end.peer] {
            const auto peer = to.lock();
            if (!peer || std::exchange(peer->closed, true)) return;
            peer->callbacks.closed({Error::Kind::closed, "the peer has gone"});
        });
    }
};

class MemoryLinks::EndLink final : public Link {
  public:
    EndLink(std::shared_ptr<Network> network, std::shared_ptr<End> end)
        : network_(std::move(network)), end_(std::move(end)) {}
    ~EndLink() override { network_->close(*end_); }

    void start(LinkCallbacks callbacks) override { end_->callbacks = std::move(callbacks); }
    bool send(const proto::Envelope& message) override {
        if (!end_->closed) network_->send(*end_, message);
        return true;
    }
    void close() override { network_->close(*end_); }
    std::size_t queued_bytes() const override {
        return network_->queued_bytes.value_or(end_->under_way_bytes);
    }
    bool ordered() const override { return true; }
    const LinkCounts& counts() const override { return end_->counts; }

  private:
    std::shared_ptr<Network> network_;
    std::shared_ptr<End> end_;
};

class MemoryLinks::MemoryListener final : public Listener {
  public:
    explicit MemoryListener(std::shared_ptr<Network> network) : network_(std::move(network)) {}
    ~MemoryListener() override { network_->on_peer = nullptr; }

    void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
        network_->on_peer = std::move(on_peer);
    }
    LinkAddress address() const override { return UnixAddress{"in memory"}; }
    std::uint64_t refused_peers() const override { return network_->refused_peers; }

  private:
    std::shared_ptr<Network> network_;
};

class MemoryLinks::MemoryConnector final : public Connector {
  public:
    MemoryConnector(std::shared_ptr<Network> network, const Patience& patience)
        : network_(std::move(network)), patience_(patience) {}

    void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) override {
        on_link_ = std::move(on_link);
        give_up_at_ = network_->clock() + patience_.limit;
        try_at(network_->clock());
    }

  private:
    void try_at(MonotonicTime time) {
        network_->at(time, [this, alive = std::weak_ptr<int>(alive_)] {
            if (alive.lock()) attempt();
        });
    }

    void attempt() {
        const MonotonicTime now = network_->clock();
        if (!network_->on_peer) {
            if (now < give_up_at_) return try_at(now + patience_.first_pause);
            return std::exchange(on_link_, {})(Error{Error::Kind::unreachable, "nobody listens"});
        }
        const auto ours = std::make_shared<End>();
        const auto theirs = std::make_shared<End>();
        ours->peer = theirs;
        theirs->peer = ours;
        auto their_link = std::make_unique<EndLink>(network_, theirs);
        std::exchange(on_link_, {})(std::unique_ptr<Link>(new EndLink(network_, ours)));
        // Another peer has a link: this one is turned away.
        if (const auto accepted = network_->accepted.lock(); accepted && !accepted->closed) {
            ++network_->refused_peers;
            return;
        }
        network_->accepted = theirs;
        network_->on_peer(std::move(their_link));
    }

    std::shared_ptr<Network> network_;
    Patience patience_;
    MonotonicTime give_up_at_{};
    std::function<void(Result<std::unique_ptr<Link>>)> on_link_;
    std::shared_ptr<int> alive_ = std::make_shared<int>();
};

inline MemoryLinks::MemoryLinks(MonotonicClock clock) : network_(std::make_shared<Network>()) {
    network_->clock = std::move(clock);
}

inline std::unique_ptr<Listener> MemoryLinks::listener() {
    return std::make_unique<MemoryListener>(network_);
}

inline std::unique_ptr<Connector> MemoryLinks::connector(const Patience& patience) {
    return std::make_unique<MemoryConnector>(network_, patience);
}

inline void MemoryLinks::set_latency(std::chrono::nanoseconds latency) { network_->latency = latency; }

inline void MemoryLinks::set_carries(std::function<bool(const proto::Envelope*)> carries) {
    network_->carries = std::move(carries);
}

inline void MemoryLinks::set_queued_bytes(std::size_t bytes) { network_->queued_bytes = bytes; }

inline bool MemoryLinks::deliver() {
    bool any = false;
    auto& under_way = network_->under_way;
    while (!under_way.empty() && under_way.begin()->first <= network_->clock()) {
        const auto deliver = std::move(under_way.begin()->second);
        under_way.erase(under_way.begin());
        deliver();
        any = true;
    }
    return any;
}

inline std::optional<MonotonicTime> MemoryLinks::next_arrival() const {
    if (network_->under_way.empty()) return std::nullopt;
    return network_->under_way.begin()->first;
}

}  // namespace afferent
