#include "afferent/io/links/pseudo_terminal.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace afferent {
namespace {

std::string link_target(const std::string& path) {
    std::error_code none;
    return std::filesystem::read_symlink(path, none).string();
}

// Whether a program that was killed has left it behind. Only links to pseudo-terminals may be removed:
// systems name their real serial lines by symbolic links, too.
bool is_left_behind(const std::string& path) { return link_target(path).starts_with("/dev/pts/"); }

}  // namespace

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

Result<NamedTerminal> NamedTerminal::open(boost::asio::io_context& io, const std::string& path) {
    auto terminal = PseudoTerminal::open(io);
    if (!terminal) return Error{terminal.error().kind, path + ": " + terminal.error().text};
    if (is_left_behind(path)) ::unlink(path.c_str());
    if (::symlink(terminal.value().device.c_str(), path.c_str()) != 0)
        return Error{Error::Kind::not_allowed, path + ": " + std::generic_category().message(errno)};
    return NamedTerminal(std::move(terminal).value(), path);
}

NamedTerminal::NamedTerminal(PseudoTerminal terminal, std::string path)
    : terminal_(std::move(terminal)), path_(std::move(path)) {}

NamedTerminal::NamedTerminal(NamedTerminal&& other) noexcept
    : terminal_(std::move(other.terminal_)), path_(std::exchange(other.path_, {})) {}

NamedTerminal::~NamedTerminal() {
    if (!path_.empty() && link_target(path_) == terminal_.device) ::unlink(path_.c_str());
}

}  // namespace afferent
