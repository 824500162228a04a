// How much of a long computation one call may do.
#pragma once

#include <cstddef>

namespace afferent {

// Work is counted and never timed, so that runs and replays do the same of it in the same call. The unit is
// about a multiplication and an addition.
class WorkBudget {
  public:
    // The work of a sine and a cosine together.
    static constexpr std::size_t sine = 24;

    explicit WorkBudget(std::size_t most) noexcept : most_(most) {}

    // False: this piece of work must wait for the next budget. A piece that is larger than a whole budget is
    // done alone.
    bool take(std::size_t piece) noexcept {
        if (done_ > 0 && (done_ > most_ || piece > most_ - done_)) return false;
        done_ += piece;
        return true;
    }
    std::size_t done() const noexcept { return done_; }

  private:
    std::size_t most_;
    std::size_t done_ = 0;
};

}  // namespace afferent
