#include "afferent/apps/waker.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cstdint>

#include "afferent/apps/failure.hpp"

namespace afferent {
namespace {

int open_event() {
    const int event = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    if (event < 0) throw Failure("eventfd: the process has too many files open");
    return event;
}

}  // namespace

Waker::Waker(boost::asio::io_context& io) : event_(io, open_event()) { wait(); }

void Waker::wake() noexcept {
    const std::uint64_t once = 1;
    // It fails where nobody has looked for 2^64 times: then the loop will wake anyway.
    [[maybe_unused]] const auto written = ::write(event_.native_handle(), &once, sizeof once);
}

void Waker::wait() {
    event_.async_wait(
        boost::asio::posix::stream_descriptor::wait_read, [this](const boost::system::error_code& error) {
            if (error) return;
            std::uint64_t times = 0;
            [[maybe_unused]] const auto read = ::read(event_.native_handle(), &times, sizeof times);
            wait();
        });
}

}  // namespace afferent
