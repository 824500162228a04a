// The loop of a process that lives with a peer: input and output, and a clock for what is due.
#pragma once

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <optional>

namespace afferent {

class EventLoop {
  public:
    using Time = std::chrono::steady_clock::time_point;

    boost::asio::io_context& io() noexcept { return io_; }

    // Calls `poll` after input, at the time that it returned, and at least every 10 ms, until it returns
    // nothing. However much input comes, `poll` has its turn. It should check for Ctrl-C.
    void run(const std::function<std::optional<Time>()>& poll) {
        while (const auto wake = poll()) {
            io_.restart();
            io_.run_one_until(
                std::min(*wake, std::chrono::steady_clock::now() + std::chrono::milliseconds(10)));
            for (int i = 0; i < most_handlers_per_turn && io_.poll_one() > 0; ++i) continue;
        }
    }

  private:
    static constexpr int most_handlers_per_turn = 64;

    boost::asio::io_context io_;
    // Without work to wait for, io_ would not wait at all: a coprocessor pauses between attempts to connect.
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_ =
        boost::asio::make_work_guard(io_);
};

}  // namespace afferent
