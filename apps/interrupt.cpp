#include "afferent/apps/interrupt.hpp"

#include <csignal>

namespace afferent {
namespace {

volatile std::sig_atomic_t asked = 0;

extern "C" void on_interrupt(int signal) {
    asked = 1;
    std::signal(signal, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
    std::signal(SIGINT, on_interrupt);
    std::signal(SIGTERM, on_interrupt);
#ifdef SIGPIPE
    std::signal(SIGPIPE, SIG_IGN);  // writing to a peer that has gone returns an error
#endif
}

bool interrupted() noexcept { return asked != 0; }

}  // namespace afferent
