#include "afferent/io/pictures/pressure_frames.hpp"

#include <vector>

namespace afferent {

PressureFrames::PressureFrames(std::uint32_t elements, TimePoint first, Duration interval, std::size_t count)
    : first_(first), interval_(interval), count_(count), forces_n_(elements), listed_(elements) {}

void PressureFrames::scan(const Scan& scan) {
    // A scan at a frame's own time belongs to it.
    keep_until(scan.time);
    for (std::size_t i = 0; i < scan.forces_n.size(); ++i) {
        const auto element = static_cast<std::uint32_t>(scan.first + i);
        if (element >= forces_n_.size()) return;
        const double force_n = scan.forces_n[i];
        forces_n_[element] = static_cast<float>(force_n);
        if (force_n > 0 && listed_[element] == 0) {
            listed_[element] = 1;
            pressed_.push_back(element);
        }
    }
}

void PressureFrames::finish(TimePoint end) { keep_until(end); }

void PressureFrames::keep_until(TimePoint time) {
    while (frames_.size() < count_ && first_ + static_cast<std::int64_t>(frames_.size()) * interval_ < time) {
        std::erase_if(pressed_, [&](std::uint32_t element) {
            if (forces_n_[element] > 0) return false;
            listed_[element] = 0;
            return true;
        });
        std::vector<Pressed>& frame = frames_.emplace_back();
        frame.reserve(pressed_.size());
        all_pressed_ += pressed_.size();
        for (const std::uint32_t element : pressed_) frame.push_back({element, forces_n_[element]});
    }
}

}  // namespace afferent
