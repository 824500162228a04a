// A shard of neurons by a sweep per scan, with the encoder before them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "afferent/encoders/encoder.hpp"
#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent {

// Drives change at multiples of the scan interval only: a sample that comes off that clock, because it was
// late, acts at the clock's next tick. What a scan interval brings is known at its beginning, and handed out
// as time goes on.
template <Encoder E>
class DenseShard final : public Shard {
  public:
    // As SparseShard.
    DenseShard(E encoder, const NeuronParameters& neuron, Duration scan_interval, Address reads,
               Address first, std::uint32_t count, SpikeLimit limit, std::string about)
        : encoder_(std::move(encoder)),
          population_(neuron, count, scan_interval, limit),
          encoding_(count),
          drives_mv_(count),
          reads_(reads),
          first_(first),
          about_(std::move(about)) {
        swept_.reserve(2 * std::size_t{count});
        reset();
    }

    void advance(TimePoint until, std::span<const Scan> scans, std::vector<Event>& events) override {
        for (const Scan& scan : scans) {
            // Up to the scan's time, but not beyond: its drives hold from there on.
            sweep(scan.time - Duration(1));
            take(scan);
        }
        sweep(until);
        const auto later = std::upper_bound(swept_.begin(), swept_.end(), Event{until, last_address});
        events.insert(events.end(), swept_.begin(), later);
        swept_.erase(swept_.begin(), later);
    }

    void reset() override {
        population_.reset();
        swept_.clear();
        std::fill(encoding_.begin(), encoding_.end(), typename E::State{});
        // Untouched skin: the bias drives it from the beginning.
        typename E::State untouched;
        std::fill(drives_mv_.begin(), drives_mv_.end(), encoder_.drive_mv(untouched, scene_start, 0));
    }

    std::size_t neurons() const noexcept override { return population_.size(); }
    std::size_t bytes() const noexcept override {
        return sizeof *this + population_.bytes() +
               encoding_.size() * (sizeof(typename E::State) + sizeof(double)) +
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

    void take(const Scan& scan) {
        const Address begin = std::max(scan.first, reads_);
        const Address end = std::min(scan.first + static_cast<Address>(scan.forces_n.size()),
                                     reads_ + static_cast<Address>(encoding_.size()));
        for (Address element = begin; element < end; ++element) {
            const Address i = element - reads_;
            drives_mv_[i] = encoder_.drive_mv(encoding_[i], scan.time, scan.forces_n[element - scan.first]);
        }
    }

    E encoder_;
    DensePopulation population_;
    std::vector<typename E::State> encoding_;
    std::vector<double> drives_mv_;
    std::vector<Event> swept_;  // not handed out yet
    Address reads_;
    Address first_;
    std::string about_;
};

}  // namespace afferent
