// A shard of neurons by prediction, with the encoder before them.
#pragma once

#include <algorithm>
#include <string>

#include "afferent/neurons/sparse_population.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/runtime/spike_storm.hpp"
#include "afferent/scene/field_encoder.hpp"

namespace afferent {

template <Encoder E, Neuron N, class Elements = Alike<N>>
class SparseShard final : public Shard {
  public:
    // Neurons of the addresses first, first + 1, ... `about` tells of them in messages.
    SparseShard(FieldEncoder<E> encoder, Elements neurons, Address first, SpikeLimit limit, std::string about)
        : encoder_(std::move(encoder)),
          population_(std::move(neurons), encoder_.size(), limit),
          first_(first),
          about_(std::move(about)) {
        reset();
    }

    void advance(TimePoint until, std::span<const Scan> scans, std::vector<Event>& events) override {
        while (!scans.empty()) {
            const std::span<const Scan> now = simultaneous(scans);
            const TimePoint time = now.front().time;
            fire(time, events);
            encoder_.take(
                now, [&](std::uint32_t i, double drive_mv) { population_.set_drive(i, time, drive_mv); });
            scans = scans.subspan(now.size());
        }
        fire(until, events);
    }

    void reset() override {
        population_.reset();
        encoder_.reset(
            [&](std::uint32_t i, double drive_mv) { population_.set_drive(i, scene_start, drive_mv); });
    }

    std::size_t bytes() const noexcept override {
        return sizeof *this - sizeof population_ + population_.bytes() + encoder_.bytes();
    }

  private:
    void fire(TimePoint until, std::vector<Event>& events) {
        population_.advance(until, [&](TimePoint time, std::uint32_t i) {
            events.push_back({time, first_ + i});
        });
        if (population_.storm())
            throw SpikeStormError(first_ + population_.storm()->index, population_.storm()->time, about_);
    }

    FieldEncoder<E> encoder_;
    SparsePopulation<N, Elements> population_;
    Address first_;
    std::string about_;
};

}  // namespace afferent
