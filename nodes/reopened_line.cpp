#include "afferent/nodes/reopened_line.hpp"

#include <chrono>
#include <thread>
#include <utility>

namespace afferent {
namespace {

constexpr std::size_t waiting_notes = 64;
constexpr std::chrono::milliseconds pause_before_opening{200};

}  // namespace

ReopenedLine::ReopenedLine(std::string device, std::uint32_t baud, std::string peer)
    : device_(std::move(device)), baud_(baud), peer_(std::move(peer)), notes_(waiting_notes) {}

Result<void> ReopenedLine::open() {
    AFFERENT_TRY(line, SerialStream::open(device_, baud_));
    line_.emplace(std::move(line));
    return success();
}

bool ReopenedLine::write(std::span<const std::byte> bytes) {
    if (line_->write(bytes)) return true;
    lose();
    return false;
}

std::optional<std::size_t> ReopenedLine::read(std::span<std::byte> bytes, Duration wait) {
    const auto count = line_->read(bytes, wait);
    if (!count) lose();
    return count;
}

void ReopenedLine::lose() {
    line_.reset();
    attempt_at_ = std::chrono::steady_clock::now() + pause_before_opening;
    tell("the line to the " + peer_ + " has failed; it is opened again as soon as it is there");
}

bool ReopenedLine::try_again() {
    std::this_thread::sleep_for(longest_look);
    const MonotonicTime now = std::chrono::steady_clock::now();
    if (now < attempt_at_) return false;
    attempt_at_ = now + pause_before_opening;
    if (!open()) return false;
    tell("the line to the " + peer_ + " is there again");
    return true;
}

bool ReopenedLine::tell(std::string note) {
    std::string* const slot = notes_.free_slot();
    if (!slot) return false;
    *slot = std::move(note);
    notes_.push();
    return true;
}

std::optional<std::string> ReopenedLine::next_note() {
    std::string* const note = notes_.next();
    if (!note) return std::nullopt;
    std::string text = std::move(*note);
    notes_.pop();
    return text;
}

}  // namespace afferent
