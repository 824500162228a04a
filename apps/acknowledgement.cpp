#include "afferent/apps/acknowledgement.hpp"

#include <csignal>

namespace afferent {
namespace {

volatile std::sig_atomic_t acknowledged = 0;
volatile std::sig_atomic_t zero_requested = 0;

extern "C" void on_user_signal(int signal) { (signal == SIGUSR1 ? acknowledged : zero_requested) = 1; }

bool take(volatile std::sig_atomic_t& flag) noexcept {
    if (flag == 0) return false;
    flag = 0;
    return true;
}

}  // namespace

void catch_user_signals() {
    struct sigaction action {};
    action.sa_handler = on_user_signal;
    action.sa_flags = SA_RESTART;
    ::sigaction(SIGUSR1, &action, nullptr);
    ::sigaction(SIGUSR2, &action, nullptr);
}

bool take_acknowledgement() noexcept { return take(acknowledged); }
bool take_zero_request() noexcept { return take(zero_requested); }

}  // namespace afferent
