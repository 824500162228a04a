#include "afferent/nodes/memory_links.hpp"

#include <algorithm>
#include <utility>

#include "afferent/io/wire/message_types.hpp"

namespace afferent {

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
    std::size_t queued_bytes() const override { return end_->under_way_bytes; }
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

MemoryLinks::MemoryLinks(MonotonicClock clock) : network_(std::make_shared<Network>()) {
    network_->clock = std::move(clock);
}

std::unique_ptr<Listener> MemoryLinks::listener() { return std::make_unique<MemoryListener>(network_); }

std::unique_ptr<Connector> MemoryLinks::connector(const Patience& patience) {
    return std::make_unique<MemoryConnector>(network_, patience);
}

void MemoryLinks::set_latency(std::chrono::nanoseconds latency) { network_->latency = latency; }

void MemoryLinks::set_carries(std::function<bool(const proto::Envelope*)> carries) {
    network_->carries = std::move(carries);
}

bool MemoryLinks::deliver() {
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

std::optional<MonotonicTime> MemoryLinks::next_arrival() const {
    if (network_->under_way.empty()) return std::nullopt;
    return network_->under_way.begin()->first;
}

}  // namespace afferent
