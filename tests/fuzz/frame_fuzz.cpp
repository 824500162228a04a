// A stream of bytes, cut anywhere, comes apart into the same messages, and never holds more than a frame.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "afferent/io/wire/frame.hpp"
#include "afferent/proto/aer.pb.h"
#include "fuzz.hpp"

namespace afferent {
namespace {

struct Parsed {
    std::vector<std::string> messages;
    FrameCounts counts;
    bool lost = false;
};

Parsed parse(std::span<const std::byte> bytes, std::size_t piece) {
    // Short, so that most inputs try the limit.
    FrameReader reader(300);
    Parsed parsed;
    proto::Envelope message;
    while (!bytes.empty() && !reader.lost()) {
        const auto space = reader.space();
        must(!space.empty());
        const std::size_t count = std::min({piece, bytes.size(), space.size()});
        std::copy_n(bytes.begin(), count, space.begin());
        reader.filled(count);
        bytes = bytes.subspan(count);
        for (;;) {
            const Result<bool> next = reader.next(message);
            if (!next && reader.lost()) break;
            if (next && !next.value()) break;
            if (next) parsed.messages.push_back(message.SerializeAsString());
        }
    }
    parsed.counts = reader.counts();
    parsed.lost = reader.lost();
    return parsed;
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::size_t piece = 1U + input.byte();
    const Parsed cut = parse(input.rest(), piece);
    const Parsed whole = parse(input.rest(), input.rest().size());
    must(cut.messages == whole.messages);
    must(cut.lost == whole.lost);
    must(cut.counts.frames == whole.counts.frames && cut.counts.refused == whole.counts.refused);

    FrameCounts counts;
    proto::Envelope message;
    if (read_datagram(input.rest(), message, counts)) must(counts.frames == 1);
    return 0;
}
