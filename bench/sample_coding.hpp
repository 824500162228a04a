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

// One element that has changed: by how many steps, and the slope by which the receiver lets it go on, or 0.
struct CountChange {
    std::uint32_t element;
    std::int32_t amount;  // not 0
    std::int32_t slope = 0;
    bool operator==(const CountChange&) const = default;
};

}  // namespace afferent
