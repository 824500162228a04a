#include "afferent/view/feed.hpp"

#include <algorithm>

namespace afferent {
namespace {

// About ten seconds of each: longer than a healthy machine ever keeps the taker from its turn.
constexpr std::size_t room_for_samples = 512;
constexpr std::size_t room_for_runs = 256;
constexpr std::size_t room_for_gaps = 256;
constexpr std::size_t room_for_links = 128;
constexpr std::size_t room_for_notes = 128;
constexpr std::size_t longest_note = 200;

std::int64_t interval_of(TimePoint time) { return (time - scene_start) / ViewFeed::sample_interval; }

ViewSample sample_of(const ControllerStep& step) {
    return {.time = step.time,
            .true_n = step.true_force_n.value_or(not_known),
            .estimate_n = step.estimate.force_n,
            .sigma_n = step.estimate.sigma_n,
            .doubt = step.estimate.doubt,
            .rate_hz = step.estimate.rate_hz,
            .gain = step.gain,
            .emg = step.effort.closing,
            .command = step.command};
}

}  // namespace

ViewFeed::ViewFeed(const RasterLayout& layout)
    : samples_(room_for_samples),
      runs_(room_for_runs,
            {0, {0, std::vector<std::uint32_t>(RasterBins::span / layout.bin() * layout.rows())}}),
      gaps_(room_for_gaps),
      links_(room_for_links),
      notes_(room_for_notes),
      bins_(layout) {}

template <class Slot, class Fill>
void ViewFeed::fill(SlotRing<Slot>& ring, const Fill& fill) {
    if (Slot* const slot = ring.free_slot()) {
        fill(*slot);
        ring.push();
    } else {
        dropped_.fetch_add(1, std::memory_order_relaxed);
    }
}

void ViewFeed::step(const ControllerStep& step) { sample(sample_of(step)); }

void ViewFeed::sample(const ViewSample& sample) {
    if (pending_ && interval_of(pending_->time) != interval_of(sample.time)) push_sample();
    pending_ = sample;
}

void ViewFeed::push_sample() {
    if (!pending_) return;
    fill(samples_, [this](auto& slot) { slot = {samples_course_, *pending_}; });
    pending_.reset();
}

void ViewFeed::steps_start_over() {
    push_sample();
    ++samples_course_;
}

void ViewFeed::push(const RasterRun& run) {
    fill(runs_, [&](auto& slot) {
        slot.course = runs_course_;
        slot.value = run;  // which has as many counts: nothing is allocated
    });
}

void ViewFeed::gap(TimePoint begin, TimePoint end) {
    begin = std::max(begin, last_event_);
    if (begin < end) fill(gaps_, [&](ViewGap& slot) { slot = {begin, end}; });
}

void ViewFeed::events_start_over() {
    events_end();
    ++runs_course_;
    last_event_ = TimePoint::min();
}

void ViewFeed::push(const LinkState& state) {
    fill(links_, [&](LinkState& slot) { slot = state; });
}

void ViewFeed::note(TimePoint time, std::string_view text) {
    fill(notes_, [&](ViewNote& slot) {
        slot.time = time;
        slot.text = text.substr(0, longest_note);
    });
}

template <class T>
void ViewFeed::look_for_course(SlotRing<InCourse<T>>& ring) {
    // What the ring holds is of its own course or later ones, in their order.
    while (const InCourse<T>* slot = ring.next()) {
        if (slot->course >= course_) return void(course_ = slot->course);
        ring.pop();
    }
}

template <class T, class Take>
void ViewFeed::take(SlotRing<InCourse<T>>& ring, const Take& take) {
    for (std::size_t left = ring.waiting(); left > 0; --left) {
        const InCourse<T>& slot = *ring.next();
        if (slot.course > course_) return;  // next time
        if (slot.course == course_) take(slot.value);
        ring.pop();
    }
}

Portion ViewFeed::take() {
    Portion portion;
    look_for_course(samples_);
    look_for_course(runs_);
    take(samples_, [&](const ViewSample& sample) { portion.samples.push_back(sample); });
    take(runs_, [&](const RasterRun& run) { portion.raster.push_back(run); });
    while (const ViewGap* gap = gaps_.next()) {
        portion.gaps.push_back(*gap);
        gaps_.pop();
    }
    while (const LinkState* state = links_.next()) {
        portion.link_points.push_back({state->time, state->bytes});
        portion.link = *state;
        links_.pop();
    }
    while (const ViewNote* note = notes_.next()) {
        portion.notes.push_back(*note);
        notes_.pop();
    }
    return portion;
}

}  // namespace afferent
