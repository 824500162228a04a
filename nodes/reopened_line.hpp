// A serial line that is opened again when it has failed, and what there is to say of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "afferent/io/links/serial_stream.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {

// One thread uses it, and another may read the notes. They are bounded: when nobody reads them, the newest is
// dropped.
class ReopenedLine {
  public:
    // How long its user waits for bytes, at most, before it looks for its end.
    static constexpr Duration longest_look = 10ms;

    // `peer` is at the other end, for people: "hand".
    ReopenedLine(std::string device, std::uint32_t baud, std::string peer);

    Result<void> open();
    bool is_open() const noexcept { return line_.has_value(); }
    // Only while it is open; false and nothing: it has failed, is closed, and that is noted.
    bool write(std::span<const std::byte> bytes);
    std::optional<std::size_t> read(std::span<std::byte> bytes, Duration wait);
    // While it is not open: waits for longest_look and, five times a second, tries. True: it is there again.
    bool try_again();

    // False: there is no room for it.
    bool tell(std::string note);
    std::optional<std::string> next_note();

  private:
    void lose();

    const std::string device_;
    const std::uint32_t baud_;
    const std::string peer_;
    std::optional<SerialStream> line_;
    MonotonicTime attempt_at_{};
    SlotRing<std::string> notes_;
};

}  // namespace afferent
