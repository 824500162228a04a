// Wakes a process's loop from another thread.
#pragma once

#include <memory>

#include "afferent/io/links/asio_forward.hpp"

namespace afferent {

// A kernel event that the loop waits for like any input.
class Waker {
  public:
    // Throws Failure if the system has none left.
    explicit Waker(boost::asio::io_context& io);
    ~Waker();
    // May be called on any thread; takes no lock and allocates nothing.
    void wake() noexcept;

  private:
    class Event;
    std::unique_ptr<Event> event_;
};

}  // namespace afferent
