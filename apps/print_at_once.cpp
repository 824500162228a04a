#include "afferent/apps/print_at_once.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>

namespace afferent {
namespace {

std::atomic<std::uint64_t> left_out{0};

}  // namespace

bool print_within(int file, std::string_view text, std::chrono::milliseconds patience) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + patience;
    while (!text.empty()) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
        pollfd ready{file, POLLOUT, 0};
        const int count = ::poll(&ready, 1, static_cast<int>(std::max(left.count(), std::int64_t{0})));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0 || !(ready.revents & POLLOUT)) return false;
        // A pipe that is ready takes as much as this without waiting for its reader.
        const ssize_t written = ::write(file, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
        if (written < 0 && errno != EINTR && errno != EAGAIN) return false;
        if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

void say(const std::string& line) {
    if (!print_within(STDERR_FILENO, line + '\n', std::chrono::milliseconds(0))) ++left_out;
}

std::uint64_t unsaid() noexcept { return left_out; }

}  // namespace afferent
