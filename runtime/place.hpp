// A place on the skin.
#pragma once

namespace afferent {

// From the centre of its patch.
struct Place {
    double x_mm = 0;
    double y_mm = 0;
    bool operator==(const Place&) const = default;
};

}  // namespace afferent
