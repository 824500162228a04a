// Experiments one after the other that report their progress and can be stopped.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "afferent/studies/trial/experiment.hpp"

namespace afferent {

// Presents nothing more once progress has returned false.
class StoppableExperiments {
  public:
    // `all`: how many presentations there will be together. `progress` is called every so often with the
    // share that is done; it may be empty, and must outlive this object.
    StoppableExperiments(const std::function<bool(double share)>& progress, double all)
        : progress_(progress), all_(all) {}

    // Stopped: those that were done by then.
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
