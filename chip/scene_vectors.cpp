#include "afferent/chip/scene_vectors.hpp"

#include <algorithm>
#include <tuple>

namespace afferent {

SceneVectors::SceneVectors(const Plan& plan, const ChipNeurons& neurons, const ChipParts& parts)
    : neurons_(neurons), parts_(parts) {
    for (const PatchPlan& patch : plan.patches)
        for (std::uint32_t i = 0; i < patch.elements(); ++i) {
            const bool alike =
                i > 0 && patch.sensor.dead_element.empty() && patch.sensor.stuck_element.empty();
            if (!alike) {
                auto& counts = counts_.emplace_back();
                const std::vector<double> forces_n = forces_of_counts(patch, i);
                for (std::uint32_t count = 0; count < forces_n.size(); ++count)
                    counts.emplace(forces_n[count], count);
            }
            patch_.push_back(counts_.size() - 1);
        }
}

// A drive that changes between two ticks counts from the next.
void SceneVectors::take(const Scan& scan) {
    const std::int64_t tick = (scan.time - scene_start).count() / neurons_.tick_ns + 1;
    for (std::size_t i = 0; i < scan.forces_n.size(); ++i) {
        const auto element = static_cast<Address>(scan.first + i);
        const auto& counts = counts_[patch_[element]];
        const auto found = counts.find(scan.forces_n[i]);
        if (found != counts.end()) read_[{tick, element}] = found->second;
    }
}

void SceneVectors::take(std::span<const Event> events) {
    for (const Event& event : events)
        events_.push_back({.tick = (event.time - scene_start).count() / neurons_.tick_ns,
                           .kind = VectorRecord::Kind::event,
                           .address = event.address});
}

Vectors SceneVectors::vectors(TimePoint end) const {
    Vectors vectors{.ticks = (end - scene_start).count() / neurons_.tick_ns, .records = events_, .lines = {}};
    for (const auto& [at, counts] : read_) {
        const auto& [tick, address] = at;
        VectorRecord record{.tick = tick, .kind = VectorRecord::Kind::reading, .address = address};
        record.input = counts;
        vectors.records.push_back(record);
        record.kind = VectorRecord::Kind::input;
        record.input = parts_.encoder->curve_of(address).input(counts);
        vectors.records.push_back(record);
    }
    std::erase_if(vectors.records, [&](const VectorRecord& record) { return record.tick > vectors.ticks; });
    add_lines(vectors, neurons_, parts_);
    return vectors;
}

}  // namespace afferent
