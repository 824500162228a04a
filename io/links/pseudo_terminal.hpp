// A serial line without the hardware.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <string>
#include <utility>

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

// A pseudo-terminal with a symbolic link to its other end, which is removed with it.
class NamedTerminal {
  public:
    // `not_allowed` where something else has that name.
    static Result<NamedTerminal> open(boost::asio::io_context& io, const std::string& path);
    NamedTerminal(NamedTerminal&& other) noexcept;
    ~NamedTerminal();

    // To be called once.
    boost::asio::posix::stream_descriptor take_ours() { return std::move(terminal_.ours); }

  private:
    NamedTerminal(PseudoTerminal terminal, std::string path);

    PseudoTerminal terminal_;
    std::string path_;  // empty once moved from
};

}  // namespace afferent
