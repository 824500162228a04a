// Which shards read which elements.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/runtime/scan.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// By blocks of elements, so that a scan of a few elements costs a look at the shards around them and not at
// all. A shard may be told of a scan that is next to what it reads.
class ScanRoutes {
  public:
    explicit ScanRoutes(const Plan& plan);

    // Calls use(shard) once for each shard that may read an element of the scan. The scan is not empty, and
    // its elements are the scene's.
    template <class Use>
    void for_each_reader(const Scan& scan, Use&& use) {
        ++visit_;
        const std::size_t last = (scan.first + scan.forces_n.size() - 1) / block;
        for (std::uint32_t k = begins_[scan.first / block]; k < begins_[last + 1]; ++k) {
            const std::uint32_t shard = shards_[k];
            if (visited_[shard] == visit_) continue;
            visited_[shard] = visit_;
            use(shard);
        }
    }

  private:
    static constexpr std::uint32_t block = 64;

    std::vector<std::uint32_t> begins_;  // by block, of its shards
    std::vector<std::uint32_t> shards_;
    std::vector<std::uint64_t> visited_;  // by shard: the scan that has met it last
    std::uint64_t visit_ = 0;
};

}  // namespace afferent
