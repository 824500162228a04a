#include "afferent/io/links/send_queue.hpp"

#include <algorithm>
#include <utility>

namespace afferent {
namespace {

constexpr std::size_t most_spare = 64;

}  // namespace

SendQueue::Pushed SendQueue::push(std::span<const std::byte> frame, Kind kind) {
    Pushed pushed = Pushed::whole;
    if (!lossless_) {
        while (!empty() && bytes_ + frame.size() > limit_bytes_ && drop_oldest_packet())
            pushed = Pushed::dropped;
        if (!empty() && bytes_ + frame.size() > 4 * limit_bytes_) return Pushed::overflow;
    }
    if (kind == Kind::follower && newest_is_dropped_) {
        ++dropped_;
        return Pushed::dropped;
    }
    if (kind != Kind::message) newest_is_dropped_ = false;
    Frame entry{.bytes = {}, .kind = kind};
    if (!spare_.empty()) {
        entry.bytes = std::move(spare_.back());
        spare_.pop_back();
    }
    entry.bytes.assign(frame.begin(), frame.end());
    bytes_ += frame.size();
    frames_.push_back(std::move(entry));
    return pushed;
}

void SendQueue::take(std::vector<std::byte>& out, std::size_t most) {
    std::size_t taken = 0;
    while (!empty()) {
        Frame& frame = frames_.front();
        if (taken > 0 && taken + frame.bytes.size() > most) return;
        taken += frame.bytes.size();
        out.insert(out.end(), frame.bytes.begin(), frame.bytes.end());
        bytes_ -= frame.bytes.size();
        recycle(std::move(frame));
        frames_.pop_front();
    }
}

// With those that follow it, up to the next that can be read without it.
bool SendQueue::drop_oldest_packet() {
    const auto oldest = [this] {
        return std::find_if(frames_.begin(), frames_.end(),
                            [](const Frame& frame) { return frame.kind != Kind::message; });
    };
    auto packet = oldest();
    if (packet == frames_.end()) return false;
    do {
        drop(packet);
        packet = oldest();
    } while (packet != frames_.end() && packet->kind == Kind::follower);
    newest_is_dropped_ = packet == frames_.end();
    return true;
}

void SendQueue::drop(std::deque<Frame>::iterator frame) {
    bytes_ -= frame->bytes.size();
    recycle(std::move(*frame));
    frames_.erase(frame);
    ++dropped_;
}

void SendQueue::recycle(Frame&& frame) {
    if (spare_.size() < most_spare) spare_.push_back(std::move(frame.bytes));
}

}  // namespace afferent
