// What a running scene tells its viewers, through rings that are filled without waiting: what finds no room
// is dropped and counted.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string_view>

#include "afferent/engine/controller.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/slot_ring.hpp"
#include "afferent/view/portion.hpp"
#include "afferent/view/raster.hpp"

namespace afferent {

// Its memory is bounded and reserved at the start. Three threads may fill it at once, one each for what
// stands under a heading below; another takes. After `starting_over` of a heading, what follows belongs to a
// new course of the scene, and its time may begin anywhere.
class ViewFeed {
  public:
    static constexpr Duration sample_interval = std::chrono::milliseconds(20);
    static constexpr Duration link_interval = std::chrono::milliseconds(100);
    // Events are at most this late. Until then a silence may still be broken.
    static constexpr Duration latest_event = std::chrono::milliseconds(250);

    explicit ViewFeed(const RasterLayout& layout);

    // The controller's steps; where there is no controller, samples of what is known.
    void step(const ControllerStep& step);
    void sample(const ViewSample& sample);
    void steps_start_over();
    void steps_end() { push_sample(); }

    // Events in the order of time, and how far time has come.
    void events(std::span<const Event> events) {
        if (!events.empty()) last_event_ = events.back().time;
        bins_.add(events, [this](const RasterRun& run) { push(run); });
    }
    void silent_until(TimePoint now) {
        if (now - scene_start < latest_event) return;
        bins_.until(now - latest_event, [this](const RasterRun& run) { push(run); });
    }
    // Packets were lost. A session that begins late tells of a gap from the scene's start: what was seen of
    // the sessions before stays known.
    void gap(TimePoint begin, TimePoint end);
    // Nobody tells of events: until the next, nothing is known.
    void events_unknown() { events_end(); }
    void events_start_over();
    void events_end() {
        bins_.finish([this](const RasterRun& run) { push(run); });
    }

    // The link. At most every 100 ms by that clock, `state` is asked for a LinkState.
    template <class State>
    void link(MonotonicTime now, const State& state) {
        if (now < link_due_) return;
        link_due_ = now + link_interval;
        push(LinkState(state()));
    }
    void push(const LinkState& state);
    void note(TimePoint time, std::string_view text);

    // For the thread that takes: the next part of one course of the scene. Courses are counted from 0; a new
    // one is begun as soon as something belongs to it, and what remains of the one before is dropped.
    Portion take();
    std::uint32_t course() const noexcept { return course_; }
    // For any thread: samples, spans of the raster, and states and notes that found no room.
    std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

  private:
    template <class T>
    struct InCourse {
        std::uint32_t course = 0;
        T value{};
    };
    template <class Slot, class Fill>
    void fill(SlotRing<Slot>& ring, const Fill& fill);
    template <class T, class Take>
    void take(SlotRing<InCourse<T>>& ring, const Take& take);
    template <class T>
    void look_for_course(SlotRing<InCourse<T>>& ring);

    void push_sample();
    void push(const RasterRun& run);

    SlotRing<InCourse<ViewSample>> samples_;
    SlotRing<InCourse<RasterRun>> runs_;
    SlotRing<ViewGap> gaps_;
    SlotRing<LinkState> links_;
    SlotRing<ViewNote> notes_;

    std::optional<ViewSample> pending_;
    std::uint32_t samples_course_ = 0;
    RasterBins bins_;
    std::uint32_t runs_course_ = 0;
    TimePoint last_event_ = TimePoint::min();
    MonotonicTime link_due_{};

    std::uint32_t course_ = 0;  // as taken
    std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace afferent
