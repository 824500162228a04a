#include "afferent/apps/acknowledgement.hpp"

#include <csignal>

namespace afferent {
namespace {

volatile std::sig_atomic_t acknowledged = 0;

extern "C" void on_acknowledgement(int) { acknowledged = 1; }

}  // namespace

void catch_acknowledgements() {
    struct sigaction action {};
    action.sa_handler = on_acknowledgement;
    action.sa_flags = SA_RESTART;
    ::sigaction(SIGUSR1, &action, nullptr);
}

bool take_acknowledgement() noexcept {
    if (acknowledged == 0) return false;
    acknowledged = 0;
    return true;
}

}  // namespace afferent
