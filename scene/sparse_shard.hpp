// A shard of neurons by prediction, with the encoder before them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "afferent/encoders/encoder.hpp"
#include "afferent/neurons/sparse_population.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent {

template <Encoder E, Neuron N>
class SparseShard final : public Shard {
  public:
    // Neurons of the addresses first, first + 1, ...; they read the elements that begin at `reads`.
    // `about` tells of them in messages.
    SparseShard(E encoder, N neuron, Address reads, Address first, std::uint32_t count, SpikeLimit limit,
                std::string about)
        : encoder_(std::move(encoder)),
          population_(std::move(neuron), count, limit),
          encoding_(count),
          reads_(reads),
          first_(first),
          about_(std::move(about)) {
        reset();
    }

    void advance(TimePoint until, std::span<const Scan> scans, std::vector<Event>& events) override {
        for (const Scan& scan : scans) {
            const Address begin = std::max(scan.first, reads_);
            const Address end = std::min(scan.first + static_cast<Address>(scan.forces_n.size()),
                                         reads_ + static_cast<Address>(encoding_.size()));
            if (begin >= end) continue;
            fire(scan.time, events);
            for (Address element = begin; element < end; ++element) {
                const Address i = element - reads_;
                population_.set_drive(
                    i, scan.time,
                    encoder_.drive_mv(encoding_[i], scan.time, scan.forces_n[element - scan.first]));
            }
        }
        fire(until, events);
    }

    void reset() override {
        population_.reset();
        std::fill(encoding_.begin(), encoding_.end(), typename E::State{});
        // Untouched skin: the bias drives it from the beginning.
        for (std::size_t i = 0; i < encoding_.size(); ++i) {
            typename E::State untouched;
            population_.set_drive(static_cast<std::uint32_t>(i), scene_start,
                                  encoder_.drive_mv(untouched, scene_start, 0));
        }
    }

    std::size_t neurons() const noexcept override { return population_.size(); }
    std::size_t bytes() const noexcept override {
        return sizeof *this - sizeof population_ + population_.bytes() + encoding_.size() * encoding_bytes;
    }

  private:
    static constexpr std::size_t encoding_bytes = sizeof(typename E::State);

    void fire(TimePoint until, std::vector<Event>& events) {
        population_.advance(until, [&](TimePoint time, std::uint32_t i) {
            events.push_back({time, first_ + i});
        });
        if (population_.storm())
            throw SpikeStormError(first_ + population_.storm()->index, population_.storm()->time, about_);
    }

    E encoder_;
    SparsePopulation<N> population_;
    std::vector<typename E::State> encoding_;
    Address reads_;
    Address first_;
    std::string about_;
};

}  // namespace afferent
