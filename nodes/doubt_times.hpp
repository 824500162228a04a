// How long an estimate has been doubted, and why.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

class DoubtTimes {
  public:
    // A doubt holds until the next step, so that the last one added does not count yet.
    void add(Doubt doubt, TimePoint time) noexcept {
        if (last_)
            times_[static_cast<std::size_t>(last_->doubt)] += std::max(time - last_->time, Duration(0));
        last_ = {doubt, time};
    }
    // By the name of the doubt; only doubts that there were.
    std::map<std::string, double> seconds() const {
        std::map<std::string, double> all;
        for (std::size_t i = 1; i < times_.size(); ++i)
            if (times_[i] > Duration(0)) all[name(static_cast<Doubt>(i))] = afferent::seconds(times_[i]);
        return all;
    }

  private:
    struct Last {
        Doubt doubt;
        TimePoint time;
    };
    std::array<Duration, static_cast<std::size_t>(last_doubt) + 1> times_{};
    std::optional<Last> last_;
};

}  // namespace afferent
