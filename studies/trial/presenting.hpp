// The presentations of a question that takes many of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "afferent/studies/trial/experiment.hpp"

namespace afferent {

// Reports how much of all is done, and presents no more once it was stopped.
class Presenting {
  public:
    // `all`: how many presentations there will be. `progress` is called with the share that is done, every so
    // often, and stops by false; it may be empty. Its owner's outlives this.
    Presenting(const std::function<bool(double share)>& progress, double all)
        : progress_(progress), all_(all) {}

    // What was done until it was stopped.
    std::vector<Presentation> present(const Scene& scene, const std::string& condition, std::uint32_t first,
                                      std::uint32_t count) {
        if (is_stopped_) return {};
        auto presented = Experiment(scene, condition).present(first, count, [&](std::uint32_t done) {
            return go_on(done_ + done);
        });
        done_ += count;
        return presented;
    }
    bool is_stopped() const noexcept { return is_stopped_; }

  private:
    bool go_on(double done) {
        if (progress_ && !progress_(std::min(1.0, done / all_))) is_stopped_ = true;
        return !is_stopped_;
    }

    const std::function<bool(double share)>& progress_;
    double all_;
    double done_ = 0;
    bool is_stopped_ = false;
};

}  // namespace afferent
