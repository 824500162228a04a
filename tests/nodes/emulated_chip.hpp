// Emulates a chip on a line: it runs the scene's neurons on a clock of its own and sends their packets. In
// virtual time.
#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/io/wire/cobs.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/chip_device.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/scene/chip_fingerprint.hpp"

namespace afferent {

class EmulatedChip {
  public:
    // The scene's source must be a chip. `counts` returns what every converter reads at a time of the chip's.
    EmulatedChip(const Scene& scene, std::function<double(TimePoint)> counts)
        : plan_(plan_with_neurons(scene)), counts_(std::move(counts)) {
        for (const PatchPlan& patch : plan_.patches) sensors_.emplace_back(patch, 1);
        begin();
    }

    void begin() {
        neurons_ = std::make_unique<Coprocessor>(plan_);
        packetizer_.emplace(*plan_.packets);
        packetizer_->announce();
        next_scan = scene_start;
        now_ = scene_start;
        said_at_ = scene_start - 1s;
    }

    // What it has put onto the line by then, by its own clock: each packet when its span ends.
    using Sink = std::function<void(TimePoint, std::vector<std::byte>)>;
    void run_until(TimePoint until, const Sink& line) {
        const Duration span = plan_.packets->span;
        for (TimePoint end = scene_start + ((now_ - scene_start) / span + 1) * span; end <= until;
             end += span) {
            for (; next_scan < end; next_scan += 5ms) read(next_scan, line);
            std::vector<Event> events;
            for (const Event& event : neurons_->advance(end - Duration(1))) {
                events.push_back(event);
                if (change) change(events);
            }
            fired.insert(fired.end(), events.begin(), events.end());
            packetizer_->push(events);
            packetizer_->close(end, [&](const proto::Envelope& packet) { send(end, packet, line); });
            now_ = end;
            if (!says_which || end - said_at_ < 100ms) continue;
            said_at_ = end;
            proto::Envelope hello;
            hello.mutable_chip()->set_version(wire_version);
            hello.mutable_chip()->set_fingerprint(*chip_fingerprint(plan_) + another);
            hello.mutable_chip()->set_addresses(plan_.addresses);
            hello.mutable_chip()->set_span_ns(static_cast<std::uint64_t>(plan_.packets->span.count()));
            send(end, hello, line);
        }
    }

    TimePoint now() const noexcept { return now_; }

    std::vector<Event> fired;
    double felt = 1;  // its neurons get this part of the readings
    bool sends_readings = true;
    bool says_which = true;                           // chip it is
    std::uint64_t another = 0;                        // chip than the scene's, if not 0
    std::function<void(std::vector<Event>&)> change;  // is given the events of a span up to each

  private:
    void read(TimePoint time, const Sink& line) {
        proto::Envelope message;
        proto::Readings& readings = *message.mutable_readings();
        const auto* const neuron = std::get_if<FixedPointParameters>(&plan_.patches[0].neuron);
        readings.set_tick(static_cast<std::uint64_t>((time - scene_start).count() /
                                                     FixedPointLif(*neuron).codes().tick_ns));
        const double counts = counts_(time);
        for (std::size_t i = 0; i < plan_.patches.size(); ++i) {
            const std::vector<double> all(plan_.patches[i].elements(), std::round(felt * counts));
            for (std::size_t k = 0; k < all.size(); ++k)
                readings.add_counts(static_cast<std::uint32_t>(counts));
            neurons_->push({time, plan_.patches[i].first_element, sensors_[i].take_counts(all)});
        }
        if (sends_readings) send(time, message, line);
    }

    void send(TimePoint time, const proto::Envelope& message, const Sink& line) {
        std::vector<std::byte> bytes;
        append_cobs(writer_.datagram(message), bytes);
        line(time, std::move(bytes));
    }

    // A plan that compares has the neurons, too.
    static Plan plan_with_neurons(Scene scene) {
        std::get<scene::Chip>(scene.source).compare = true;
        return make_plan(scene);
    }

    const Plan plan_;
    std::function<double(TimePoint)> counts_;
    std::vector<PatchSensors> sensors_;
    std::unique_ptr<Coprocessor> neurons_;
    std::optional<Packetizer> packetizer_;
    FrameWriter writer_;
    TimePoint next_scan = scene_start;
    TimePoint now_ = scene_start;
    TimePoint said_at_ = scene_start;
};

}  // namespace afferent
