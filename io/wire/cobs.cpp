#include "afferent/io/wire/cobs.hpp"

#include <algorithm>
#include <cassert>

namespace afferent {
namespace {

constexpr std::byte zero{0};
constexpr std::size_t longest_block = 254;

}  // namespace

void append_cobs(std::span<const std::byte> datagram, std::vector<std::byte>& out) {
    assert(!datagram.empty());
    out.push_back(zero);
    for (auto rest = datagram;;) {
        const auto begin = rest.begin();
        const auto last = begin + static_cast<std::ptrdiff_t>(std::min(rest.size(), longest_block));
        const auto end = std::find(begin, last, zero);
        const auto length = static_cast<std::size_t>(end - begin);
        out.push_back(std::byte(length + 1));
        out.insert(out.end(), begin, end);
        // A block's end stands for a zero, except after a block of full length.
        const bool has_zero = length < longest_block && end != rest.end();
        rest = rest.subspan(length + (has_zero ? 1 : 0));
        if (rest.empty() && !has_zero) break;
    }
    out.push_back(zero);
}

void CobsReader::read(std::span<const std::byte> bytes,
                      const std::function<void(std::span<const std::byte>)>& sink) {
    for (const std::byte byte : bytes) {
        if (byte != zero) {
            add(byte);
            continue;
        }
        if (too_long_ || left_in_block_ > 0)
            ++refused_;
        else if (!datagram_.empty())
            sink(datagram_);
        restart();
    }
}

void CobsReader::add(std::byte byte) {
    if (too_long_) return;
    const bool begins_block = left_in_block_ == 0;
    if (!begins_block || zero_is_due_) {
        if (datagram_.size() == longest_) {
            too_long_ = true;
            return;
        }
        datagram_.push_back(begins_block ? zero : byte);
    }
    if (begins_block) {
        left_in_block_ = std::to_integer<unsigned>(byte) - 1;
        zero_is_due_ = left_in_block_ < longest_block;
    } else {
        --left_in_block_;
    }
}

void CobsReader::restart() noexcept {
    datagram_.clear();
    left_in_block_ = 0;
    zero_is_due_ = false;
    too_long_ = false;
}

}  // namespace afferent
