#include "afferent/nodes/chip_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/io/wire/message_types.hpp"

namespace afferent {
namespace {

bool before(const Event& a, const Event& b) {
    return a.time != b.time ? a.time < b.time : a.address < b.address;
}

// Readings come before the packet of their time.
constexpr Duration longest_lead = 1s;
// A chip that has sent none by then sends none at all.
constexpr Duration readings_due = 2s;

Duration tick_of_neurons(const Plan& plan) {
    const NeuronModel model = plan.patches.front().neuron_of(0);
    return Duration(FixedPointLif(std::get<FixedPointParameters>(model)).codes().tick_ns);
}

// Ticks until values of that range that decay by this factor are equal: rounded, they stick where a tick
// takes less than half a unit; truncated, they lose the rest by one unit a tick, in one more time constant.
double ticks_to_forget(std::int64_t range, std::int64_t decay, std::int64_t one) {
    const double kept = static_cast<double>(decay) / static_cast<double>(one);
    const double time_constant = kept > 0 ? -1 / std::log(kept) : 1;
    return time_constant * (1 + std::log(std::max(1.0, 2 * static_cast<double>(range) * (1 - kept))));
}

// u is the same after g.
Duration time_to_forget(const Plan& plan) {
    double longest_ns = 0;
    for (const PatchPlan& patch : plan.patches) {
        const NeuronModel model = patch.neuron_of(0);
        const FixedPointLif::Codes c = FixedPointLif(std::get<FixedPointParameters>(model)).codes();
        double ticks = ticks_to_forget(c.highest - c.lowest, c.v_decay, c.one);
        if (c.g_jump > 0) ticks += ticks_to_forget(c.g_most, c.g_decay, c.one);
        longest_ns = std::max(longest_ns, ticks * static_cast<double>(c.tick_ns));
    }
    return Duration(static_cast<std::int64_t>(std::min(longest_ns, 1e15)));
}

}  // namespace

ChipComparison::ChipComparison(const Plan& plan, Coprocessor& emulator)
    : emulator_(emulator),
      tick_(plan.timing.tick),
      neuron_tick_(tick_of_neurons(plan)),
      forgotten_after_(time_to_forget(plan)),
      afferents_(plan.addresses) {
    patches_.reserve(plan.patches.size());
    for (const PatchPlan& patch : plan.patches)
        if (patch.owns_elements)
            patches_.push_back({patch.first_element, patch.elements(), PatchSensors(patch, plan.scene.seed)});
    given_.reserve(plan.elements);
}

void ChipComparison::restart(TimePoint begin) {
    emulator_.reset();
    begun_ = begin - scene_start;
    std::ranges::fill(afferents_, Afferent());
}

void ChipComparison::lose() {
    std::ranges::fill(afferents_, Afferent{.is_known = false, .silent_since = emulator_.now() + begun_});
}

// The readings of whole patches are used, those of parts of a patch are not.
void ChipComparison::read(const proto::Readings& readings) {
    const std::uint64_t first = readings.first();
    const std::uint64_t end = first + static_cast<std::uint64_t>(readings.counts_size());
    const auto latest = static_cast<std::uint64_t>((Duration::max() / 2) / neuron_tick_);
    const TimePoint time =
        scene_start - begun_ + static_cast<std::int64_t>(std::min(readings.tick(), latest)) * neuron_tick_;
    bool used = false;
    if (time >= emulator_.now() && time < emulator_.now() + longest_lead)
        for (Patch& patch : patches_) {
            if (patch.first < first || patch.first + patch.elements > end) continue;
            const auto begin = readings.counts().begin() + static_cast<std::ptrdiff_t>(patch.first - first);
            given_.assign(begin, begin + static_cast<std::ptrdiff_t>(patch.elements));
            emulator_.push({time, patch.first, patch.sensors.take_counts(given_)});
            used = true;
        }
    if (!used) {
        ++counts_.refused_readings;
        return;
    }
    ++counts_.readings;
}

void ChipComparison::compare(const Reception& reception) {
    if (reception.gap) lose();
    if (!reception.measured()) return;
    const auto events = emulator_.advance(reception.known.end - begun_ - Duration(1));
    if (counts_.readings == 0) return wait_for_readings(reception);
    emulated_.clear();
    for (const Event& event : events) {
        // As its packet has it: in the wire's tick.
        const Duration since = event.time - scene_start + begun_;
        const Event stamped{scene_start + since / tick_ * tick_, event.address};
        if (stamped.time >= reception.known.begin) emulated_.push_back(stamped);
    }
    std::ranges::sort(emulated_, before);
    auto mine = emulated_.begin();
    auto its = reception.events.begin();
    while (mine != emulated_.end() || its != reception.events.end()) {
        if (its == reception.events.end() || (mine != emulated_.end() && before(*mine, *its))) {
            differ(*mine++, "the emulator", counts_.emulator_alone);
        } else if (mine == emulated_.end() || before(*its, *mine)) {
            differ(*its++, "the chip", counts_.chip_alone);
        } else {
            agree(*mine);
            ++mine, ++its;
        }
    }
}

// Before what the event itself changes.
bool ChipComparison::knows_state(const Event& event) {
    Afferent& afferent = afferents_[event.address];
    if (!afferent.is_known && event.time - afferent.silent_since >= forgotten_after_) afferent = {};
    afferent.silent_since = event.time;
    return afferent.is_known;
}

void ChipComparison::agree(const Event& event) {
    ++counts_.equal;
    if (knows_state(event)) return;
    ++afferents_[event.address].equal;
    judge(event.address);
}

void ChipComparison::judge(Address address) {
    Afferent& afferent = afferents_[address];
    ++afferent.events;
    if (afferent.events == judged && 2 * afferent.equal < judged)
        tell("of the first " + std::to_string(judged) + " events of address " + std::to_string(address) +
             " " + std::to_string(afferent.equal) +
             " are equal in chip and emulator: they differ, unless the chip was heard in the midst of a "
             "touch");
}

void ChipComparison::tell(std::string note) {
    if (told_ == most_told) return;
    if (++told_ == most_told) note += "; of further ones only the numbers are told";
    notes_.push_back(std::move(note));
}

void ChipComparison::wait_for_readings(const Reception& reception) {
    if (!reception.events.empty()) lose();
    counts_.not_compared += reception.events.size();
    if (reception.known.end - begun_ < scene_start + readings_due || std::exchange(told_missing_, true))
        return;
    notes_.push_back(
        "the chip sends no readings that the emulator could be given, so that nothing is compared");
}

void ChipComparison::differ(const Event& event, const char* who, std::uint64_t& count) {
    if (!knows_state(event)) {
        ++counts_.not_compared;
        return judge(event.address);
    }
    ++count;
    tell("chip and emulator part at " + std::to_string(seconds(event.time)) + " s of the chip, after " +
         std::to_string(counts_.equal) + " equal events: address " + std::to_string(event.address) +
         " fires in " + who + " alone");
}

std::optional<std::string> ChipComparison::next_note() {
    if (notes_.empty()) return std::nullopt;
    std::string note = std::move(notes_.front());
    notes_.pop_front();
    return note;
}

}  // namespace afferent
