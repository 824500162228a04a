// What a decoder takes to read an event, by how many afferents feel the force.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct CostRow {
    std::uint32_t afferents;
    std::string decoder;
    double events_per_s;  // of the scene
    // Of its thread's own time, packets of 5 ms; the median of five passes, with the least and the most.
    double ns_per_event, least_ns, most_ns;
    double ns_per_estimate;  // one for each packet
    // The part of one core that both take while the scene lasts.
    double core() const noexcept { return 1e-9 * (events_per_s * ns_per_event + 200 * ns_per_estimate); }
};

// The window and the filter on the grasp's nine afferents, and on up to 11,111 copies of them that share its
// force; on one thread. `progress` is told the fraction that is done.
std::vector<CostRow> measure_cost(const Scene& grasp, bool quick,
                                  const std::function<void(double)>& progress);

// cost.csv. Throws std::runtime_error where it cannot be written.
void write_cost(const std::vector<CostRow>& rows, const std::filesystem::path& folder);
void print_cost(const std::vector<CostRow>& rows, std::ostream& out);

}  // namespace afferent
