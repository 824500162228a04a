// Signals of a hand's user. SIGUSR1: the hand may operate again that went safe. SIGUSR2: nothing touches its
// sensors now, so that their zero can be taken.
#pragma once

namespace afferent {

void catch_user_signals();
// Whether there has been one since this was last asked.
bool take_acknowledgement() noexcept;
bool take_zero_request() noexcept;

}  // namespace afferent
