// A stream of any bytes through a cutter, in any pieces: nothing is added or moved, nothing but the beginning
// of a piece is held back, and each frame or segment comes out as one.
#include <algorithm>
#include <vector>

#include "afferent/io/links/stream_cutter.hpp"
#include "afferent/io/wire/frame.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

using Bytes = std::span<const std::byte>;

// Where the pieces end that do not depend on how the stream comes; and whether all else is passed on at once.
struct Expected {
    std::vector<std::size_t> ends;
    bool passes_on = false;
};

Expected expected(Bytes stream, CutInto pieces) {
    Expected found{.ends = {}, .passes_on = pieces == CutInto::reads};
    for (std::size_t begin = 0; begin < stream.size() && !found.passes_on;) {
        const Bytes rest = stream.subspan(begin);
        std::size_t size = 0;
        if (pieces == CutInto::frames) {
            const auto claimed = stream_frame_size(rest);
            found.passes_on = !claimed;
            if (claimed && *claimed <= rest.size()) size = *claimed;
        } else if (const auto zero = std::find(rest.begin(), rest.end(), std::byte{0}); zero != rest.end()) {
            size = static_cast<std::size_t>(zero - rest.begin()) + 1;
        }
        if (size == 0) break;
        begin += size;
        found.ends.push_back(begin);
    }
    return found;
}

void cut(Bytes stream, CutInto pieces, std::size_t at_once) {
    const Expected expected = afferent::expected(stream, pieces);
    StreamCutter cutter(pieces);
    std::size_t passed = 0;
    std::size_t count = 0;
    const auto take = [&](Bytes piece) {
        must(!piece.empty() && piece.size() <= stream.size() - passed);
        must(std::equal(piece.begin(), piece.end(), stream.begin() + static_cast<std::ptrdiff_t>(passed)));
        passed += piece.size();
        if (count < expected.ends.size()) must(passed == expected.ends[count]);
        ++count;
    };
    for (Bytes rest = stream; !rest.empty(); rest = rest.subspan(std::min(at_once, rest.size())))
        cutter.push(rest.first(std::min(at_once, rest.size())), take);
    must(count >= expected.ends.size());
    if (expected.passes_on)
        must(passed == stream.size());
    else
        must(count == expected.ends.size());
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::uint8_t choice = input.byte();
    const std::size_t at_once = 1U + input.byte();
    constexpr CutInto kinds[] = {CutInto::frames, CutInto::segments, CutInto::reads};
    cut(input.rest(), kinds[choice % std::size(kinds)], at_once);
    return 0;
}
