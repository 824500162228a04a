#include "bench/sample_coding.hpp"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <array>

namespace afferent {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;

std::uint32_t zigzag(std::int32_t value) { return WireFormatLite::ZigZagEncode32(value); }

void append_varint(std::string& out, std::uint32_t value) {
    std::array<std::uint8_t, 5> bytes;
    const auto* end = CodedOutputStream::WriteVarint32ToArray(value, bytes.data());
    out.append(reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(end - bytes.data()));
}

CodedInputStream varints(std::string_view payload) {
    return CodedInputStream(reinterpret_cast<const std::uint8_t*>(payload.data()),
                            static_cast<int>(payload.size()));
}

}  // namespace

void encode_raw(Counts counts, unsigned bits, std::string& payload) {
    std::uint32_t pending = 0;
    unsigned used = 0;
    for (const std::uint16_t count : counts) {
        pending |= std::uint32_t{count} << used;
        for (used += bits; used >= 8; used -= 8, pending >>= 8) payload.push_back(static_cast<char>(pending));
    }
    if (used > 0) payload.push_back(static_cast<char>(pending));
}

bool decode_raw(std::string_view payload, unsigned bits, std::span<std::uint16_t> counts) {
    std::uint32_t pending = 0;
    unsigned used = 0;
    std::size_t element = 0;
    for (const char byte : payload) {
        pending |= std::uint32_t{static_cast<unsigned char>(byte)} << used;
        if ((used += 8) < bits || element == counts.size()) continue;
        counts[element++] = static_cast<std::uint16_t>(pending & ((1U << bits) - 1));
        pending >>= bits;
        used -= bits;
    }
    return element == counts.size();
}

void encode_differences(Counts counts, Counts before, std::string& payload) {
    for (std::size_t e = 0; e < counts.size(); ++e) append_varint(payload, zigzag(counts[e] - before[e]));
}

bool decode_differences(std::string_view payload, Counts before, std::span<std::uint16_t> counts) {
    CodedInputStream in = varints(payload);
    for (std::size_t e = 0; e < counts.size(); ++e) {
        std::uint32_t delta = 0;
        if (!in.ReadVarint32(&delta)) return false;
        counts[e] = static_cast<std::uint16_t>(before[e] + WireFormatLite::ZigZagDecode32(delta));
    }
    return true;
}

}  // namespace afferent
