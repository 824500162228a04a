// A line of any bytes, cut anywhere: the same datagrams, none too long, and each comes back from a line of
// its own.
#include <algorithm>
#include <vector>

#include "afferent/io/wire/cobs.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;

// Short, so that most inputs try the limit.
constexpr std::size_t longest = 300;

struct Read {
    std::vector<Bytes> datagrams;
    std::uint64_t refused = 0;

    friend bool operator==(const Read&, const Read&) = default;
};

Read read(std::span<const std::byte> line, std::size_t piece) {
    CobsReader reader(longest);
    Read found;
    for (; !line.empty(); line = line.subspan(std::min(piece, line.size())))
        reader.read(line.first(std::min(piece, line.size())),
                    [&](auto datagram) { found.datagrams.emplace_back(datagram.begin(), datagram.end()); });
    found.refused = reader.refused();
    return found;
}

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::size_t piece = 1U + input.byte();
    const auto line = input.rest();
    const Read whole = read(line, line.size());
    must(read(line, piece) == whole);
    const auto ends = std::count(line.begin(), line.end(), std::byte{0});
    must(whole.datagrams.size() + whole.refused <= static_cast<std::size_t>(ends));

    Bytes again;
    for (const Bytes& datagram : whole.datagrams) {
        must(!datagram.empty() && datagram.size() <= longest);
        append_cobs(datagram, again);
    }
    must(read(again, piece) == Read{whole.datagrams, 0});

    // The input as a datagram.
    if (line.empty() || line.size() > longest) return 0;
    again.clear();
    append_cobs(line, again);
    must(read(again, piece) == Read{{Bytes(line.begin(), line.end())}, 0});
    return 0;
}
