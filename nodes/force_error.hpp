// The error of an estimate against the true force, where that is known.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace afferent {

class ForceError {
  public:
    void add(double estimate_n, double true_n) noexcept {
        const double error = estimate_n - true_n;
        squares_ += error * error;
        largest_ = std::max(largest_, std::abs(error));
        ++count_;
    }
    // Root mean square and largest, in N; nothing where the true force was never known.
    std::optional<double> rms_n() const {
        return count_ ? std::optional(std::sqrt(squares_ / static_cast<double>(count_))) : std::nullopt;
    }
    std::optional<double> max_n() const { return count_ ? std::optional(largest_) : std::nullopt; }

  private:
    double squares_ = 0;
    double largest_ = 0;
    std::uint64_t count_ = 0;
};

}  // namespace afferent
