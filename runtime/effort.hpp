// What a user's muscles ask of the hand.
#pragma once

namespace afferent {

// Each 0 (at rest) to 1 (as hard as possible).
struct Effort {
    double closing = 0;
    double opening = 0;
};

}  // namespace afferent
