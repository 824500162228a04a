#include "afferent/nodes/overdue_scans.hpp"

#include <cstddef>

namespace afferent {

void OverdueScans::hold(const Scan& scan) {
    time_ = scan.time;
    for (std::size_t i = 0; i < scan.forces_n.size(); ++i) {
        const std::size_t element = scan.first + i;
        if (element >= held_.size()) return;  // the scene does not have it
        forces_n_[element] = scan.forces_n[i];
        if (held_[element])
            ++skipped_;
        else
            ++count_;
        held_[element] = true;
    }
}

}  // namespace afferent
