// How samples are put into payloads: the alternatives to events, each in both directions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace afferent {

// Converter counts of neighbouring elements; of several scans in a row where a packet has several.
using Counts = std::span<const std::uint16_t>;

// Encoding appends to the payload. Decoding returns false where the payload ends too early.

// Every count in so many bits.
void encode_raw(Counts counts, unsigned bits, std::string& payload);
bool decode_raw(std::string_view payload, unsigned bits, std::span<std::uint16_t> counts);

// The difference of every count from the one before it, as a varint.
void encode_differences(Counts counts, Counts before, std::string& payload);
bool decode_differences(std::string_view payload, Counts before, std::span<std::uint16_t> counts);

// Send-on-delta: the elements that have changed, in increasing order, and by how many whole deltas.
struct CountChange {
    std::uint32_t element;
    std::int32_t deltas;
    bool operator==(const CountChange&) const = default;
};
void encode_changes(std::span<const CountChange> changes, std::string& payload);
bool decode_changes(std::string_view payload, std::vector<CountChange>& changes);

// What of each element was sent last. Both ends begin at 0.
class SendOnDelta {
  public:
    // step > 0, in counts.
    SendOnDelta(std::uint32_t elements, int step) : step_(step), sent_(elements, 0) {}

    // Appends what has changed in a scan. `first` is added to the number of each element.
    void send(Counts scan, std::uint32_t first, std::vector<CountChange>& changes);

    int step() const noexcept { return step_; }
    const std::vector<int>& sent() const noexcept { return sent_; }

  private:
    int step_;
    std::vector<int> sent_;
};

}  // namespace afferent
