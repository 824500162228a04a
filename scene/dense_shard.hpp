// A shard of neurons by a sweep per scan, with the encoder before them.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/runtime/spike_storm.hpp"
#include "afferent/scene/field_encoder.hpp"

namespace afferent {

// Drives change at multiples of the scan interval only: a late sample, off that clock, acts at the next
// multiple. The events of an interval are computed at its beginning, and handed out as time goes on.
template <Encoder E>
class DenseShard final : public Shard {
  public:
    // Neurons of the addresses first, first + 1, ... `about` tells of them in messages.
    DenseShard(FieldEncoder<E> encoder, DensePopulation population, Address first, std::string about)
        : encoder_(std::move(encoder)),
          population_(std::move(population)),
          drives_mv_(encoder_.size()),
          first_(first),
          about_(std::move(about)) {
        swept_.reserve(2 * drives_mv_.size());
        reset();
    }

    void advance(TimePoint until, std::span<const Scan> scans, std::vector<Event>& events) override {
        while (!scans.empty()) {
            const std::span<const Scan> now = simultaneous(scans);
            // Up to the scan's time, but not beyond: its drives hold from there on.
            sweep(now.front().time - Duration(1));
            encoder_.take(now, [&](std::uint32_t i, double drive_mv) { drives_mv_[i] = drive_mv; });
            scans = scans.subspan(now.size());
        }
        sweep(until);
        const auto later = std::upper_bound(swept_.begin(), swept_.end(), Event{until, last_address});
        events.insert(events.end(), swept_.begin(), later);
        swept_.erase(swept_.begin(), later);
    }

    void reset() override {
        population_.reset();
        swept_.clear();
        encoder_.reset([&](std::uint32_t i, double drive_mv) { drives_mv_[i] = drive_mv; });
    }

    std::size_t bytes() const noexcept override {
        return sizeof *this + population_.bytes() + encoder_.bytes() + drives_mv_.size() * sizeof(double) +
               swept_.capacity() * sizeof(Event);
    }

  private:
    static constexpr Address last_address = std::numeric_limits<Address>::max();

    // All scan intervals that have begun by then.
    void sweep(TimePoint until) {
        while (population_.time() <= until) {
            population_.advance(drives_mv_, [&](TimePoint time, std::uint32_t i) {
                swept_.push_back({time, first_ + i});
            });
            if (population_.storm())
                throw SpikeStormError(first_ + population_.storm()->index, population_.storm()->time, about_);
        }
    }

    FieldEncoder<E> encoder_;
    DensePopulation population_;
    std::vector<double> drives_mv_;
    std::vector<Event> swept_;  // not handed out yet
    Address first_;
    std::string about_;
};

}  // namespace afferent
