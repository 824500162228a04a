// Rank 0's end of the exchange: it collects the events of all ranks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "afferent/nodes/event_exchange.hpp"
#include "afferent/nodes/ranks/messages.hpp"
#include "afferent/nodes/ranks/patience.hpp"
#include "afferent/nodes/ranks/sorted_runs.hpp"
#include "afferent/nodes/ranks/stopwatch.hpp"
#include "afferent/nodes/ranks/world.hpp"

namespace afferent::ranks {

// Where the other ranks sample for themselves, they run ahead, and their events have usually arrived when
// this rank's are computed. Where they are sent the samples of each window, they wait for these, and this
// rank waits for their events.
class EventGather final : public EventExchange {
  public:
    // computes[r]: rank r has neurons. The world outlives it.
    EventGather(World& world, const std::vector<bool>& computes, bool sends_samples, Patience patience);
    // Ends the other ranks, if nobody has.
    ~EventGather() override;

    void push(const Scan& scan) override;
    void begin(TimePoint until) override;
    Result<std::span<const Event>> exchange(TimePoint until, std::span<const Event> own) override;

    // Ends the other ranks, wherever they are. To be called before reports().
    void end();
    // By rank; all zero for one that gave none.
    const std::vector<Report>& reports() const noexcept { return reports_; }
    // Why an exchange failed; none comes after it.
    const std::optional<Error>& error() const noexcept { return error_; }

  private:
    struct Other {
        std::size_t rank;
        bool computes;
        Outbox outbox;
        // Its events up to `until`, of which the first `taken` have been handed out.
        std::vector<Event> events{};
        std::size_t taken = 0;
        TimePoint until = TimePoint::min();
        bool ended = false;
    };

    // Receives what has come from it. False: nothing has.
    bool receive_from(Other& other);
    bool has_sent(Other& other, TimePoint until);
    void wait_for(Other& other, TimePoint until);
    void fail(const Other& other, const std::string& what);

    World& world_;
    bool sends_samples_;
    Patience patience_;
    std::vector<Other> others_;
    Buffers buffers_;
    std::shared_ptr<Bytes> samples_;  // of the window that is open
    Bytes received_;
    SortedRuns merged_;
    std::vector<Report> reports_;
    std::optional<Error> error_;
    Stopwatch stopwatch_;
    bool ended_ = false;
};

}  // namespace afferent::ranks
