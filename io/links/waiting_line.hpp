// The peers of a listener that have proven nothing yet. For the transports and the view.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>

namespace afferent {

// A bounded line: when it is full, the oldest makes way for the next that enters, so that peers that connect
// and prove nothing keep nobody out. A peer that has proven nothing in time has to leave. Owned by a
// shared_ptr.
class WaitingLine : public std::enable_shared_from_this<WaitingLine> {
  public:
    using Place = std::uint64_t;
    static constexpr std::size_t most = 64;
    static constexpr std::chrono::milliseconds patience{1000};

    template <class Executor>
    explicit WaitingLine(Executor&& executor, std::size_t most_waiting = most,
                         std::chrono::milliseconds patience_with_each = patience)
        : timer_(std::forward<Executor>(executor)), most_(most_waiting), patience_(patience_with_each) {}

    // `turn_away` is called when this peer has to leave, and not after it has left by itself.
    Place enter(std::function<void()> turn_away) {
        if (waiting_.size() == most_) turn_away_oldest();
        waiting_.emplace(next_, Waiting{Clock::now() + patience_, std::move(turn_away)});
        if (waiting_.size() == 1) watch();
        return next_++;
    }
    void leave(Place place) { waiting_.erase(place); }
    // Turns everybody away.
    void close() {
        while (!waiting_.empty()) turn_away_oldest();
        timer_.cancel();
    }

  private:
    using Clock = std::chrono::steady_clock;

    struct Waiting {
        Clock::time_point deadline;
        std::function<void()> turn_away;
    };

    void turn_away_oldest() {
        const auto oldest = waiting_.extract(waiting_.begin());
        oldest.mapped().turn_away();
    }

    void watch() {
        timer_.expires_at(waiting_.begin()->second.deadline);
        timer_.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
            const auto self = weak.lock();
            if (error || !self) return;
            while (!self->waiting_.empty() && self->waiting_.begin()->second.deadline <= Clock::now())
                self->turn_away_oldest();
            if (!self->waiting_.empty()) self->watch();
        });
    }

    boost::asio::steady_timer timer_;
    const std::size_t most_;
    const std::chrono::milliseconds patience_;
    std::map<Place, Waiting> waiting_;  // the oldest first
    Place next_ = 0;
};

}  // namespace afferent
