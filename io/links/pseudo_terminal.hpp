// A serial line without the hardware.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <string>

#include "afferent/runtime/result.hpp"

namespace afferent {

struct PseudoTerminal {
    // Raw in both directions. `unreachable` with the system's reason.
    static Result<PseudoTerminal> open(boost::asio::io_context& io);

    boost::asio::posix::stream_descriptor ours;
    // The other end, kept open so that ours outlives the process that uses it.
    boost::asio::posix::stream_descriptor held;
    std::string device;  // the other end's
};

}  // namespace afferent
