// A serial line as bytes, for a thread that has nothing else to wait for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "afferent/runtime/result.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

class SerialStream {
  public:
    // Opens a tty for this program alone. `unreachable` with the system's reason.
    static Result<SerialStream> open(const std::string& device, std::uint32_t baud);
    SerialStream(SerialStream&& other) noexcept;
    SerialStream& operator=(SerialStream&& other) noexcept;
    ~SerialStream();

    // Writes at once what the system has room for; the rest is lost. False: the line has failed.
    bool write(std::span<const std::byte> bytes) noexcept;
    // Waits for bytes, for less than a second, and reads what has come: how many bytes, 0 if none. Nothing if
    // the line has failed.
    std::optional<std::size_t> read(std::span<std::byte> bytes, Duration wait) noexcept;

  private:
    struct Device;
    explicit SerialStream(std::unique_ptr<Device> device);

    std::unique_ptr<Device> device_;
};

}  // namespace afferent
