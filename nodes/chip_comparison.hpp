// A chip beside its emulator: event by event, where do they part?
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/io/wire/messages.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// All times are the chip's. The emulator is given the readings that the chip says it has had, and has to fire
// what the chip fires. Where something of the chip is not known (a frame was lost, or it was heard only in
// the midst of its time), states differ, and with them the times of spikes, for as long as a touch holds. An
// afferent's differences count again once it has been silent for so long that its integers are the same
// whatever they were.
class ChipComparison {
  public:
    // If most of the first so many events of an afferent since then are not equal, that is told.
    static constexpr std::uint32_t judged = 100;
    // No more differences than these are told one by one.
    static constexpr std::uint64_t most_told = 10;

    struct Counts {
        std::uint64_t readings = 0;
        std::uint64_t equal = 0;
        std::uint64_t chip_alone = 0;      // events of the chip that the emulator does not have
        std::uint64_t emulator_alone = 0;  // and the other way round
        std::uint64_t not_compared = 0;    // differ, as states may
        std::uint64_t refused_readings = 0;
    };

    // Both outlive it. The coprocessor is the emulator, and nobody else's.
    ChipComparison(const Plan& plan, Coprocessor& emulator);

    // The chip is followed from this time of its own. Its neurons are taken to be at rest then.
    void restart(TimePoint begin);
    // Nothing is known of the chip for a while.
    void lose();
    void read(const proto::Readings& readings);
    void compare(const Reception& reception);

    // The length of a tick of the chip's neurons.
    Duration neuron_tick() const noexcept { return neuron_tick_; }
    const Counts& counts() const noexcept { return counts_; }
    // Where they part, in order; nothing if that is all.
    std::optional<std::string> next_note();

  private:
    void wait_for_readings(const Reception& reception);
    bool knows_state(const Event& event);
    void agree(const Event& event);
    void differ(const Event& event, const char* who, std::uint64_t& count);
    void judge(Address address);
    void tell(std::string note);

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
    Duration forgotten_after_;  // of silence
    struct Afferent {
        bool is_known = true;
        // Since something was lost: when it was last not silent, events, and those that were equal.
        TimePoint silent_since = scene_start;
        std::uint32_t events = 0;
        std::uint32_t equal = 0;
    };
    std::vector<Afferent> afferents_;  // by address
    std::uint64_t told_ = 0;
    bool told_missing_ = false;
    std::deque<std::string> notes_;
};

}  // namespace afferent
