// The states of a grip. Included by programs that control a hand or report on one.
#pragma once

namespace afferent {

// operating: EMG and gain determine the command. frozen: the closing command may not increase. safe: the
// scene's SafeState holds.
enum class GripState { operating, frozen, safe };

// The behaviour of a hand in GripState::safe.
enum class SafeState {
    hold,  // does not close; the user may open
    open,  // opens by itself
};

// What re-arms a safe hand: a new session whose packets arrive; by_user: the user's acknowledgement in
// addition.
enum class Rearm { new_session, by_user };

}  // namespace afferent
