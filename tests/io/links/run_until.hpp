// Runs the I/O of a test.
#pragma once

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <chrono>

namespace afferent {

// Until the condition holds; a minute without it is a failure. `each` is called in between, as a program's
// loop does.
template <class Condition, class Each>
void run_until(boost::asio::io_context& io, Condition condition, Each each) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!condition()) {
        ASSERT_LT(std::chrono::steady_clock::now(), limit) << "waited in vain";
        io.restart();
        io.run_one_for(std::chrono::milliseconds(10));
        each();
    }
}

// Everything that has been sent to sockets of this machine, which is there at once.
inline void run_all(boost::asio::io_context& io) {
    do io.restart();
    while (io.poll() > 0);
}

}  // namespace afferent
