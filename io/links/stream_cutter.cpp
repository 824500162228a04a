#include "afferent/io/links/stream_cutter.hpp"

#include <algorithm>

#include "afferent/io/wire/frame.hpp"

namespace afferent {

void StreamCutter::push(std::span<const std::byte> bytes,
                        const std::function<void(std::span<const std::byte>)>& take) {
    rest_.insert(rest_.end(), bytes.begin(), bytes.end());
    std::span<const std::byte> left = rest_;
    while (const std::size_t size = left.empty() ? 0 : piece(left)) {
        take(left.first(size));
        left = left.subspan(size);
    }
    rest_.erase(rest_.begin(), rest_.end() - static_cast<std::ptrdiff_t>(left.size()));
}

std::size_t StreamCutter::piece(std::span<const std::byte> bytes) {
    if (pieces_ == CutInto::frames) {
        const auto size = stream_frame_size(bytes);
        if (size) return *size <= bytes.size() ? *size : 0;
        pieces_ = CutInto::reads;
    }
    if (pieces_ == CutInto::segments) {
        const auto zero = std::find(bytes.begin(), bytes.end(), std::byte{0});
        if (zero != bytes.end()) return static_cast<std::size_t>(zero - bytes.begin()) + 1;
        return bytes.size() > max_message_bytes ? bytes.size() : 0;
    }
    return bytes.size();
}

}  // namespace afferent
