// What the closing command of a hand may be.
#pragma once

namespace afferent {

// Operating: the user and the gain decide. Frozen: it may not increase. Safe: the scene's safe state.
enum class GripState { operating, frozen, safe };

}  // namespace afferent
