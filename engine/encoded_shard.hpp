// A shard of neurons in any form, with the encoder before them.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "afferent/encoders/field_encoder.hpp"
#include "afferent/engine/noisy_drive.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent {

// Takes the spikes of a shard that begins with that address. One type for all encoders, so that what fires
// them is compiled once for each kind of neurons.
struct AddressedKeys {
    EventKeys& events;
    Address first;

    void operator()(TimePoint time, std::uint32_t i) const { events.add(time, first + i); }
};

// `Neurons` has the members that PredictedNeurons tells of.
template <Encoder E, class Neurons>
class EncodedShard final : public Shard {
  public:
    // Neurons of the addresses first, first + 1, ... `about` tells of them in messages.
    EncodedShard(FieldEncoder<E> encoder, Neurons neurons, Address first, const DriveNoise& noise,
                 std::string about)
        : encoder_(std::move(encoder)),
          neurons_(std::move(neurons)),
          first_(first),
          noise_(noise),
          about_(std::move(about)) {
        reset();
    }

    void advance(TimePoint until, std::span<const Scan> scans, EventKeys& events) override {
        const AddressedKeys sink{events, first_};
        neurons_.begin_window(until, sink);
        while (!scans.empty()) {
            const std::span<const Scan> now = simultaneous(scans);
            const TimePoint time = now.front().time;
            neurons_.begin_scan(time, sink);
            neurons_.set_drives(time, [&](auto&& set) {
                if (noise_.is_none()) return encoder_.take(now, set);
                const auto set_noisy = [&](std::size_t i, double drive_mv) {
                    set(i, noise_(drive_mv, first_ + static_cast<Address>(i), time));
                };
                // The noise takes longer than a call, which all kinds of neurons share.
                encoder_.take(now, SetDrive(std::ref(set_noisy)));
            });
            neurons_.end_scan(time);
            scans = scans.subspan(now.size());
        }
        neurons_.end_window(sink);
        if (const auto& storm = neurons_.storm())
            throw SpikeStormError(first_ + storm->index, storm->time, about_);
    }

    TimePoint next() const noexcept override { return neurons_.next(); }

    void reset() override {
        neurons_.reset();
        neurons_.set_drives(scene_start, [&](auto&& set) {
            encoder_.reset([&](std::size_t i, double drive_mv) {
                noise_.set_rest(drive_mv);
                set(i, drive_mv);
            });
        });
    }

    std::size_t bytes() const noexcept override {
        return sizeof *this - sizeof neurons_ + neurons_.bytes() + encoder_.bytes();
    }
    bool is_dense() const noexcept override { return neurons_.is_dense(); }
    std::uint64_t form_changes() const noexcept override { return neurons_.form_changes(); }

  private:
    using SetDrive = std::function<void(std::size_t i, double drive_mv)>;

    FieldEncoder<E> encoder_;
    Neurons neurons_;
    Address first_;
    NoisyDrive noise_;
    std::string about_;
};

}  // namespace afferent
