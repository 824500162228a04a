// A serial line without the hardware.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <string>

#include "afferent/io/wire/result.hpp"

namespace afferent {

struct PseudoTerminal {
    // Raw, both ways. `unreachable` with the system's words.
    static Result<PseudoTerminal> open(boost::asio::io_context& io);

    boost::asio::posix::stream_descriptor ours;
    // The other end is open all the while, so that ours does not end with the process there.
    boost::asio::posix::stream_descriptor held;
    std::string device;  // the other end's
};

}  // namespace afferent
