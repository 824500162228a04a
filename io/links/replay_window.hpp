// Recognises numbered datagrams of a session that have come before.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>

namespace afferent {

// Remembers the newest number and the ones just before it (RFC 6347, 4.1.2.6). What is older than that cannot
// be told from a replay. Numbers begin at 1.
class ReplayWindow {
  public:
    static constexpr std::size_t width = 128;

    bool is_new(std::uint64_t number) const {
        if (number > newest_) return true;
        const std::uint64_t age = newest_ - number;
        return number > 0 && age < width && !taken_[static_cast<std::size_t>(age)];
    }

    // To be called once the number is known to be authentic. Returns whether it is the newest.
    bool take(std::uint64_t number) {
        if (number <= newest_) {
            taken_.set(static_cast<std::size_t>(newest_ - number));
            return false;
        }
        const std::uint64_t step = number - newest_;
        taken_ = step < width ? taken_ << static_cast<std::size_t>(step) : std::bitset<width>();
        taken_.set(0);
        newest_ = number;
        return true;
    }

  private:
    std::uint64_t newest_ = 0;
    std::bitset<width> taken_;  // by age
};

}  // namespace afferent
