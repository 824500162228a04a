// A place on the skin. Included by whoever builds a scene with afferents in space.
#pragma once

namespace afferent {

// Relative to the centre of its patch, or on the map of the body where that is said.
struct Position {
    double x_mm = 0;
    double y_mm = 0;
    bool operator==(const Position&) const = default;
};

}  // namespace afferent
