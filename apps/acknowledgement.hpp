// SIGUSR1: the user acknowledges that a hand may operate again that went safe.
#pragma once

namespace afferent {

void catch_acknowledgements();
// Whether there has been one since this was last asked.
bool take_acknowledgement() noexcept;

}  // namespace afferent
