// What the closing command of a hand may be.
#pragma once

namespace afferent {

// Operating: as the user and the gain say. Frozen: no increase. Safe: the scene's safe state.
enum class GripState { operating, frozen, safe };

}  // namespace afferent
