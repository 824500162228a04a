// A chip beside its emulator: event by event, where do they part?
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// All times are the chip's. The emulator is given the readings that the chip says it has had, and has to fire
// what the chip fires. Where something of the chip is not known (a frame was lost, or it was heard only in
// the midst of its time), the two differ by that, until their neurons have forgotten it: what happens until
// four of the slowest time constants have passed, and the last `settled` events were equal, is not compared.
class ChipComparison {
  public:
    static constexpr std::uint64_t settled = 20;
    static constexpr std::uint64_t most_told = 10;

    struct Counts {
        std::uint64_t readings = 0;
        std::uint64_t equal = 0;
        std::uint64_t chip_alone = 0;      // events of the chip that the emulator does not have
        std::uint64_t emulator_alone = 0;  // and the other way round
        std::uint64_t not_compared = 0;
        std::uint64_t refused_readings = 0;
    };

    // Both outlive it. The coprocessor is the emulator, and nobody else's.
    ChipComparison(const Plan& plan, Coprocessor& emulator);

    // The chip is followed from this time of its own. Its neurons are taken to be at rest then.
    void restart(TimePoint begin);
    // Nothing is known of the chip for a while.
    void lose() noexcept {
        settling_ = true;
        in_a_row_ = 0;
        lost_at_ = emulator_.now();
    }
    void read(const proto::Readings& readings);
    void compare(const Reception& reception);

    // Of the chip's neurons.
    Duration neuron_tick() const noexcept { return neuron_tick_; }
    const Counts& counts() const noexcept { return counts_; }
    // Where they part, in order: of each of the first `most_told` events that differ.
    std::optional<std::string> next_note();

  private:
    void wait_for_readings(const Reception& reception);
    void differ(const Event& event, const char* who, std::uint64_t& count);

    Coprocessor& emulator_;
    Duration tick_;         // of the wire
    Duration neuron_tick_;  // of the neurons
    Duration begun_{};      // where the chip's time is the emulator's 0
    struct Patch {
        Address first;
        std::uint32_t elements;
        PatchSensors sensors;
    };
    std::vector<Patch> patches_;
    std::vector<double> given_;
    std::vector<Event> emulated_;
    Counts counts_;
    Duration forgotten_after_;
    bool settling_ = false;
    TimePoint lost_at_ = scene_start;
    std::uint64_t in_a_row_ = 0;
    std::uint64_t told_ = 0;
    bool told_missing_ = false;
    std::deque<std::string> notes_;
};

}  // namespace afferent
