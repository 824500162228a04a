#include "afferent/apps/waker.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cstdint>

#include "afferent/apps/failure.hpp"

namespace afferent {

class Waker::Event {
  public:
    explicit Event(boost::asio::io_context& io) : descriptor_(io, open()) { wait(); }

    void write() noexcept {
        const std::uint64_t once = 1;
        // Fails only after 2^64 unread writes; the loop is due to wake up then anyway.
        [[maybe_unused]] const auto written = ::write(descriptor_.native_handle(), &once, sizeof once);
    }

  private:
    static int open() {
        const int event = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
        if (event < 0) throw Failure("eventfd: the process has too many files open");
        return event;
    }

    void wait() {
        descriptor_.async_wait(
            boost::asio::posix::stream_descriptor::wait_read, [this](const boost::system::error_code& error) {
                if (error) return;
                std::uint64_t times = 0;
                [[maybe_unused]] const auto read = ::read(descriptor_.native_handle(), &times, sizeof times);
                wait();
            });
    }

    boost::asio::posix::stream_descriptor descriptor_;
};

Waker::Waker(boost::asio::io_context& io) : event_(std::make_unique<Event>(io)) {}
Waker::~Waker() = default;

void Waker::wake() noexcept { event_->write(); }

}  // namespace afferent
