// Wakes a process's loop from another thread.
#pragma once

#include <boost/asio/posix/stream_descriptor.hpp>
#include <memory>

namespace afferent {

// An event of the kernel's, for which the loop waits as for any input.
class Waker {
  public:
    // Throws Failure where the system has none left.
    explicit Waker(boost::asio::io_context& io);
    // For any thread; takes no lock and allocates nothing.
    void wake() noexcept;

  private:
    void wait();

    boost::asio::posix::stream_descriptor event_;
};

}  // namespace afferent
