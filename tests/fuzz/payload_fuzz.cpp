// Every payload that is accepted could have come from the encoder, and encodes to no more bytes.
#include <algorithm>

#include "afferent/io/wire/payload.hpp"
#include "fuzz.hpp"
#include "layouts.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::uint8_t choice = input.byte();
    const PacketLayout& layout = fuzz_layout(choice);
    PayloadCodec& codec = made_for_fuzz_layout<PayloadCodec>(choice);
    const std::uint32_t spans = layout.gathered_spans;
    const auto decoded = codec.decode(input.rest(), spans);
    if (!decoded) return 0;
    const std::vector<Code> codes(decoded.value().begin(), decoded.value().end());
    must(codes.size() <= layout.max_events);
    must(std::is_sorted(codes.begin(), codes.end()));
    must(codes.empty() || codes.back() < layout.codes());

    std::string payload;
    codec.encode(codes, payload, spans);
    must(payload.size() <= input.rest().size());
    const auto again = codec.decode(std::as_bytes(std::span(payload)), spans);
    must(again && std::equal(codes.begin(), codes.end(), again.value().begin(), again.value().end()));
    return 0;
}
