#include "afferent/io/links/pseudo_terminal.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace afferent {

Result<PseudoTerminal> PseudoTerminal::open(boost::asio::io_context& io) {
    const auto failed = [] {
        return Error{Error::Kind::unreachable,
                     "there are no pseudo-terminals here: " + std::generic_category().message(errno)};
    };
    PseudoTerminal terminal{
        boost::asio::posix::stream_descriptor(io), boost::asio::posix::stream_descriptor(io), {}};
    const int ours = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (ours < 0) return failed();
    terminal.ours.assign(ours);
    std::array<char, 128> name{};
    if (::grantpt(ours) != 0 || ::unlockpt(ours) != 0 || ::ptsname_r(ours, name.data(), name.size()) != 0)
        return failed();
    terminal.device = name.data();
    const int held = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (held < 0) return failed();
    terminal.held.assign(held);
    termios settings{};
    if (::tcgetattr(held, &settings) != 0) return failed();
    ::cfmakeraw(&settings);
    if (::tcsetattr(held, TCSANOW, &settings) != 0) return failed();
    return terminal;
}

}  // namespace afferent
