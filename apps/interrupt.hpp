// Ctrl-C, and the polite kill: asked for once, a command ends cleanly; asked for again, the program ends at
// once.
#pragma once

namespace afferent {

void catch_interrupts();
bool interrupted() noexcept;

}  // namespace afferent
