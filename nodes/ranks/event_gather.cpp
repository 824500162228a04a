#include "afferent/nodes/ranks/event_gather.hpp"

#include <algorithm>

namespace afferent::ranks {
namespace {

constexpr int failed_code = 1;

}  // namespace

EventGather::EventGather(World& world, const std::vector<bool>& computes, bool sends_samples,
                         Patience patience)
    : world_(world),
      sends_samples_(sends_samples),
      patience_(std::move(patience)),
      samples_(buffers_.next()),
      reports_(world.size()),
      stopwatch_(reports_.front()) {
    for (std::size_t rank = 1; rank < world.size(); ++rank)
        others_.push_back({.rank = rank, .computes = computes[rank], .outbox = Outbox(rank)});
}

EventGather::~EventGather() { end(); }

void EventGather::push(const Scan& scan) {
    if (sends_samples_) put_scan(*samples_, scan);
}

void EventGather::begin(TimePoint until) {
    if (sends_samples_) {
        put_end(*samples_, until);
        for (Other& other : others_) {
            (void)other.outbox.waiting();
            if (other.computes) other.outbox.send(Kind::samples, samples_);
        }
        samples_ = buffers_.next();
    }
    stopwatch_.computes();
}

Result<std::span<const Event>> EventGather::exchange(TimePoint until, std::span<const Event> own) {
    stopwatch_.does_the_rest();
    for (Other& other : others_) (void)has_sent(other, until);
    stopwatch_.waits();
    for (Other& other : others_) wait_for(other, until);
    stopwatch_.does_the_rest();
    ++reports_.front().windows;
    reports_.front().events += own.size();
    if (error_) return *error_;
    merged_.clear();
    merged_.add(own);
    for (Other& other : others_) {
        const auto left = std::span<const Event>(other.events).subspan(other.taken);
        // A window that was cut short hands out a part of the others' events.
        const auto end = std::partition_point(left.begin(), left.end(),
                                              [&](const Event& event) { return event.time <= until; });
        merged_.add({left.begin(), end});
        other.taken += static_cast<std::size_t>(end - left.begin());
    }
    return merged_.merged();
}

// Receives what has come. True where nothing more is needed of it, or will come.
bool EventGather::has_sent(Other& other, TimePoint until) {
    if (other.taken == other.events.size()) {
        other.events.clear();
        other.taken = 0;
    }
    while (other.computes && !error_ && other.until < until)
        if (!receive_from(other)) return false;
    return true;
}

void EventGather::wait_for(Other& other, TimePoint until) {
    if (wait(patience_, [&] { return has_sent(other, until); })) return;
    world_.give_up(failed_code);
    const std::string window = "its events up to " + std::to_string(seconds(until)) + " s";
    if (patience_.interrupted())
        fail(other, "has not sent " + window + " before the run was told to end; it may have died");
    else
        fail(other,
             "has not sent " + window + " within " +
                 std::to_string(
                     std::chrono::duration_cast<std::chrono::milliseconds>(patience_.longest).count()) +
                 " ms (--rank-timeout): it hangs, or cannot be reached");
}

bool EventGather::receive_from(Other& other) {
    const std::optional<Kind> kind = receive(other.rank, received_);
    if (!kind) return false;
    switch (*kind) {
        case Kind::events:
            other.until = take_events(received_, other.events);
            break;
        case Kind::failure:
            // What a rank that was ahead met with after the run's end is nobody's concern.
            if (!ended_)
                fail(other, std::string(reinterpret_cast<const char*>(received_.data()), received_.size()));
            break;
        case Kind::report:
            reports_[other.rank] = take_report(received_);
            other.ended = true;
            break;
        case Kind::samples:
        case Kind::stop:
            break;  // from rank 0 alone
    }
    return true;
}

void EventGather::fail(const Other& other, const std::string& what) {
    if (!error_)
        error_ = Error{Error::Kind::closed, "rank " + std::to_string(other.rank) + " of " +
                                                std::to_string(world_.size()) + ": " + what};
}

// A rank that has failed to answer is not waited for again.
void EventGather::end() {
    if (std::exchange(ended_, true)) return;
    stopwatch_.stop();
    for (Other& other : others_) other.outbox.send(Kind::stop, buffers_.next());
    for (Other& other : others_) {
        const bool ended = wait(patience_, [&] {
            // What was on its way is of no use any more.
            while (!other.ended && receive_from(other)) other.events.clear();
            return other.ended && other.outbox.waiting() == 0;
        });
        if (!ended) {
            world_.give_up(failed_code);
            break;
        }
    }
}

}  // namespace afferent::ranks
