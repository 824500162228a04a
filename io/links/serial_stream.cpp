#include "afferent/io/links/serial_stream.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "afferent/io/links/serial_device.hpp"

namespace afferent {

struct SerialStream::Device {
    boost::asio::io_context io;
    std::optional<boost::asio::serial_port> port;
};

SerialStream::SerialStream(std::unique_ptr<Device> device) : device_(std::move(device)) {}
SerialStream::SerialStream(SerialStream&& other) noexcept = default;
SerialStream& SerialStream::operator=(SerialStream&& other) noexcept = default;
SerialStream::~SerialStream() = default;

Result<SerialStream> SerialStream::open(const std::string& device, std::uint32_t baud) {
    auto opened = std::make_unique<Device>();
    AFFERENT_TRY(port, open_serial_device(opened->io, device, baud));
    if (::fcntl(port.native_handle(), F_SETFL, O_NONBLOCK) != 0)
        return Error{Error::Kind::unreachable, std::generic_category().message(errno)};
    opened->port.emplace(std::move(port));
    return SerialStream(std::move(opened));
}

bool SerialStream::write(std::span<const std::byte> bytes) noexcept {
    return ::write(device_->port->native_handle(), bytes.data(), bytes.size()) >= 0 || errno == EAGAIN ||
           errno == EINTR;
}

std::optional<std::size_t> SerialStream::read(std::span<std::byte> bytes, Duration wait) noexcept {
    pollfd waited{.fd = device_->port->native_handle(), .events = POLLIN, .revents = 0};
    const timespec limit{.tv_sec = 0, .tv_nsec = std::clamp<Duration>(wait, 0ns, 999ms).count()};
    if (::ppoll(&waited, 1, &limit, nullptr) <= 0) return 0;
    const ssize_t count = ::read(waited.fd, bytes.data(), bytes.size());
    if (count > 0) return static_cast<std::size_t>(count);
    const bool none_yet = count < 0 && (errno == EAGAIN || errno == EINTR);
    return none_yet ? std::optional<std::size_t>(0) : std::nullopt;
}

}  // namespace afferent
