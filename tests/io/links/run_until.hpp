// Runs the I/O of a test.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <stdexcept>

namespace afferent {

// Until the condition holds; throws after a minute without it, which fails the test. `each` is called in
// between, as a program's loop does.
template <class Condition, class Each>
void run_until(boost::asio::io_context& io, Condition condition, Each each) {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > limit) throw std::runtime_error("waited in vain");
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
