// Cuts a stream of bytes into the pieces that a channel loses, repeats or changes whole.
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
    reads,     // as the bytes come: nothing in an encrypted stream can be told apart
};

class StreamCutter {
  public:
    explicit StreamCutter(CutInto pieces) : pieces_(pieces) {}

    // Hands over every piece that is whole by now; the span is valid during the call. What claims to be
    // longer than a frame may be is handed over as it comes, and so is everything after it.
    void push(std::span<const std::byte> bytes, const std::function<void(std::span<const std::byte>)>& take);

  private:
    // Of the first piece; 0 while it is not whole.
    std::size_t piece(std::span<const std::byte> bytes);

    CutInto pieces_;
    std::vector<std::byte> rest_;
};

}  // namespace afferent
