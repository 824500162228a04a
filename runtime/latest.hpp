// The latest value of something, from one thread to another: neither waits, and nothing is torn.
#pragma once

#include <array>
#include <atomic>

namespace afferent {

// Three copies: one that is being written, one that is being read, and the latest between them.
template <class T>
class Latest {
  public:
    // By the one thread that tells.
    void tell(const T& value) {
        copies_[writing_] = value;
        writing_ = between_.exchange(writing_ | fresh, std::memory_order_acq_rel) & index;
    }

    // By the one thread that reads; valid until it reads again.
    const T& read() noexcept {
        if (between_.load(std::memory_order_relaxed) & fresh)
            reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & index;
        return copies_[reading_];
    }

  private:
    static constexpr unsigned fresh = 4;
    static constexpr unsigned index = 3;

    std::array<T, 3> copies_{};
    unsigned writing_ = 0;
    unsigned reading_ = 1;
    std::atomic<unsigned> between_{2};
};

}  // namespace afferent
