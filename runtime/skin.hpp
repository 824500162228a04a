// The skin that a scene's elements cover, seen from above.
#pragma once

#include <vector>

#include "afferent/runtime/position.hpp"

namespace afferent {

struct Skin {
    struct Element {
        Position place = {};
        double width_mm = 0;  // of its square; 0: its patch has no dimensions

        // Under that force; 0 where it has no dimensions.
        double pressure_kpa(double force_n) const noexcept {
            return width_mm > 0 ? 1e3 * force_n / (width_mm * width_mm) : 0;
        }
    };

    std::vector<std::vector<Position>> outlines = {};  // each a closed curve
    std::vector<Element> elements = {};                // by their number among all elements of the scene
};

}  // namespace afferent
