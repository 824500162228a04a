#include "afferent/nodes/ranks/worker.hpp"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/ranks/messages.hpp"
#include "afferent/nodes/ranks/patience.hpp"
#include "afferent/nodes/ranks/stopwatch.hpp"

namespace afferent::ranks {
namespace {

// How many windows all ranks together may be ahead of rank 0; each of them some.
constexpr std::size_t windows_ahead = 65'536;
constexpr std::size_t most_ahead = 1024;
constexpr std::size_t least_ahead = 16;

// Sends the events of each window.
class Delivery final : public EventExchange {
  public:
    explicit Delivery(const World& world)
        : ahead_(std::clamp(windows_ahead / world.size(), least_ahead, most_ahead)) {
        // Rank 0 may take any time, reading samples or drawing a picture. If it has died, MPI ends this rank.
        forever_.longest = std::chrono::hours(24 * 365);
    }

    void push(const Scan&) override {}
    void begin(TimePoint) override { stopwatch_.computes(); }

    Result<std::span<const Event>> exchange(TimePoint until, std::span<const Event> own) override {
        stopwatch_.waits();
        wait(forever_, [&] { return stopped() || to_first_.waiting() < ahead_; });
        stopwatch_.does_the_rest();
        if (stopped_) return Error{Error::Kind::closed, "rank 0 has ended"};
        const auto bytes = buffers_.next();
        put_events(*bytes, until_, until, own);
        ++report_.windows;
        report_.events += own.size();
        report_.bytes += bytes->size();
        to_first_.send(Kind::events, bytes);
        until_ = until;
        return std::span<const Event>();
    }

    void count_samples(std::uint64_t samples, std::uint64_t clipped) {
        report_.samples = samples;
        report_.clipped = clipped;
    }

    // The next samples; null when there are none any more.
    const Bytes* wait_for_samples() {
        stopwatch_.waits();
        bool came = false;
        wait(forever_, [&] { return stopped_ || (came = receive_samples()); });
        stopwatch_.does_the_rest();
        return came ? &received_ : nullptr;
    }

    void fail(const std::string& what) {
        if (stopped_) return;
        const auto bytes = buffers_.next();
        const auto text = std::as_bytes(std::span(what));
        bytes->assign(text.begin(), text.end());
        to_first_.send(Kind::failure, bytes);
    }

    // Waits until rank 0 says that it is over.
    void end() {
        stopwatch_.stop();
        wait(forever_, [&] { return (void)to_first_.waiting(), stopped(); });
        const auto bytes = buffers_.next();
        put_report(*bytes, report_);
        to_first_.send(Kind::report, bytes);
        wait(forever_, [&] { return to_first_.waiting() == 0; });
    }

  private:
    bool stopped() {
        if (!stopped_) (void)receive_samples();
        return stopped_;
    }

    // False: they are not there yet, or it is over.
    bool receive_samples() {
        const auto kind = receive(0, received_);
        if (kind == Kind::stop) stopped_ = true;
        return kind == Kind::samples;
    }

    Patience forever_;
    std::size_t ahead_;
    Outbox to_first_{0};
    Buffers buffers_;
    Bytes received_;
    Report report_;
    TimePoint until_ = scene_start - Duration(1);
    Stopwatch stopwatch_{report_};
    bool stopped_ = false;
};

// Samples for itself.
Result<void> sample_and_compute(const Plan& plan, Delivery& delivery) {
    AFFERENT_TRY(link_end, CoprocessorEnd::open(plan, {}, &delivery));
    const auto run = [&]() -> Result<void> {
        while (link_end->next().time < plan.end()) {
            AFFERENT_TRY(link_end->do_next({}));
        }
        link_end->finish(plan.end(), {});
        return success();
    };
    const Result<void> done = run();
    delivery.count_samples(link_end->source()->samples(), link_end->source()->clipped());
    return done;
}

Result<void> compute(const Plan& plan, Delivery& delivery) {
    Coprocessor coprocessor(plan);
    std::vector<double> forces_n;
    while (const Bytes* samples = delivery.wait_for_samples()) {
        const TimePoint until =
            take_scans(*samples, forces_n, [&](const Scan& scan) { coprocessor.push(scan); });
        delivery.begin(until);
        AFFERENT_TRY(delivery.exchange(until, coprocessor.advance(until)));
    }
    return success();
}

}  // namespace

void work(const World& world, Plan& plan, const Share& share) {
    Delivery delivery(world);
    // What becomes of the events is up to rank 0.
    plan.packets.reset();
    plan.bus.reset();
    plan.controller.reset();
    try {
        if (!plan.shards.empty()) {
            const Result<void> done =
                share.samples_are_sent ? compute(plan, delivery) : sample_and_compute(plan, delivery);
            if (!done) delivery.fail(done.error().text);
        }
    } catch (const std::exception& error) {
        delivery.fail(error.what());
    }
    delivery.end();
}

}  // namespace afferent::ranks
