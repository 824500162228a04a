// Cuts a stream of bytes into pieces, each of which a channel loses, repeats or changes as a whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace afferent {

enum class CutInto : std::uint8_t {
    frames,    // as FrameWriter::stream_frame writes them
    segments,  // up to each zero byte, as on a serial line
    reads,     // whatever is read at once: an encrypted stream shows no boundaries
};

class StreamCutter {
  public:
    explicit StreamCutter(CutInto pieces) : pieces_(pieces) {}

    // Hands over every complete piece; the span is valid during the call. After a length that no frame can
    // have, the bytes are handed over as they come.
    void push(std::span<const std::byte> bytes, const std::function<void(std::span<const std::byte>)>& take);

  private:
    // The size of the first piece; 0 while it is incomplete.
    std::size_t piece(std::span<const std::byte> bytes);

    CutInto pieces_;
    std::vector<std::byte> rest_;
};

}  // namespace afferent
