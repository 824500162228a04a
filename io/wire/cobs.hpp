// Datagrams on a line of bytes: consistent overhead byte stuffing (Cheshire and Baker, IEEE/ACM Transactions
// on Networking 7, 1999).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace afferent {

// A zero begins and ends each datagram and occurs nowhere else: noise before a datagram costs nothing but
// itself. Between them stand blocks: a byte n, then n − 1 bytes that are not zero, then a zero that is not
// sent, unless n is 255 or the datagram ends there. The cost is three bytes, and another for every 254 bytes
// without a zero.
//
// Appends a datagram, which must not be empty, to the bytes to be sent.
void append_cobs(std::span<const std::byte> datagram, std::vector<std::byte>& out);

// Finds datagrams on a line that may be cut or disturbed anywhere: it is back in step after the next zero.
// Its memory is allocated at construction.
class CobsReader {
  public:
    // Longer datagrams are dropped.
    explicit CobsReader(std::size_t longest) : longest_(longest) { datagram_.reserve(longest); }

    // The datagrams that end in these bytes, each valid until the sink returns.
    void read(std::span<const std::byte> bytes, const std::function<void(std::span<const std::byte>)>& sink);

    // How often the bytes between two zeros were not a datagram, or too long.
    std::uint64_t refused() const noexcept { return refused_; }

  private:
    void add(std::byte byte);
    void restart() noexcept;

    std::size_t longest_;
    std::vector<std::byte> datagram_;
    unsigned left_in_block_ = 0;
    bool zero_is_due_ = false;  // should another block follow
    bool too_long_ = false;
    std::uint64_t refused_ = 0;
};

}  // namespace afferent
