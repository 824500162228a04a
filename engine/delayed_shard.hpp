// A shard whose afferents have a nerve: their events leave a fixed time after they have fired.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "afferent/runtime/event_key.hpp"
#include "afferent/runtime/shard.hpp"

namespace afferent {

class DelayedShard final : public Shard {
  public:
    DelayedShard(std::unique_ptr<Shard> shard, Duration delay) : shard_(std::move(shard)), delay_(delay) {}

    void advance(TimePoint until, std::span<const Scan> scans, EventKeys& events) override {
        spikes_.begin(events.base());
        shard_->advance(until, scans, spikes_);
        std::ranges::sort(spikes_.keys());
        for (const EventKey key : spikes_.keys()) {
            Event event = EventKeys::event(events.base(), key);
            event.time += delay_;
            under_way_.push_back(event);
        }
        // One after the other, windows leave in order.
        const auto left = std::ranges::find_if(under_way_, [&](const Event& e) { return e.time > until; });
        for (auto event = under_way_.begin(); event != left; ++event) events.add(event->time, event->address);
        under_way_.erase(under_way_.begin(), left);
    }

    TimePoint next() const noexcept override {
        return under_way_.empty() ? shard_->next() : std::min(under_way_.front().time, shard_->next());
    }

    void reset() override {
        shard_->reset();
        under_way_.clear();
    }

    std::size_t bytes() const noexcept override {
        return sizeof *this + shard_->bytes() + spikes_.keys().capacity() * sizeof(EventKey) +
               under_way_.capacity() * sizeof(Event);
    }
    bool is_dense() const noexcept override { return shard_->is_dense(); }
    std::uint64_t form_changes() const noexcept override { return shard_->form_changes(); }

  private:
    std::unique_ptr<Shard> shard_;
    Duration delay_;
    EventKeys spikes_;              // of a window
    std::vector<Event> under_way_;  // sorted by time
};

}  // namespace afferent
