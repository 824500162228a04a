// What the closing command of a hand may be.
#pragma once

namespace afferent {

// Operating: the user and the gain decide. Frozen: it may not increase. Safe: the scene's safe state.
enum class GripState { operating, frozen, safe };

// What the hand does in GripState::safe.
enum class SafeState {
    hold,  // closes no further; the user may open
    open,  // opens by itself
};

}  // namespace afferent
