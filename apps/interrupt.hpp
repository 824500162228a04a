// SIGINT (Ctrl-C) and SIGTERM: the first lets the command end cleanly, the second ends the program at once.
#pragma once

namespace afferent {

void catch_interrupts();
bool interrupted() noexcept;

}  // namespace afferent
