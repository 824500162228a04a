// The main loop of a process on a link: input and output, a timer for the next step, and Ctrl-C.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>

#include "afferent/apps/interrupt.hpp"

namespace afferent {

class EventLoop {
  public:
    // The time between two calls of `housekeeping`.
    static constexpr std::chrono::milliseconds housekeeping_period{10};

    // `pump` does what is due and returns the time of its next call; it is also called after every input.
    // `housekeeping` looks after the session and Ctrl-C.
    using Pump = std::function<std::chrono::steady_clock::time_point()>;

    boost::asio::io_context& io() noexcept { return io_; }

    void run(const Pump& pump, const std::function<void()>& housekeeping) {
        auto next_housekeeping = std::chrono::steady_clock::now();
        while (!stopped_) {
            const auto now = std::chrono::steady_clock::now();
            if (now >= next_housekeeping) {
                housekeeping();
                next_housekeeping = now + housekeeping_period;
            }
            const auto wake = std::min(pump(), next_housekeeping);
            if (stopped_) break;
            io_.restart();
            io_.run_one_until(wake);
            io_.poll();
        }
    }
    void stop() noexcept { stopped_ = true; }

  private:
    boost::asio::io_context io_;
    bool stopped_ = false;
};

}  // namespace afferent
