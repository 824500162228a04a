#include "afferent/studies/trial/crossing.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

// The search is in the logarithm of the parameter and the log odds of the proportion, where a proportion that
// rises with the parameter is nearly a straight line.
double log_odds(double share) { return std::log(share / (1 - share)); }

struct Point {
    double x;
    Proportion counted;
    double y;  // log odds above the target
};

class Search {
  public:
    Search(const CrossingSearch& search, const CountAt& count)
        : search_(search),
          count_(count),
          few_(std::min(search.presentations, std::clamp(search.presentations / 8, 50U, 2000U))),
          // Nothing is nearer than half a presentation.
          tolerance_(std::max(search.tolerance, 0.5 / search.presentations)) {}

    std::optional<Crossing> find() {
        const auto low = at(std::log(search_.low), few_);
        if (!low) return std::nullopt;
        const auto high = at(std::log(search_.high), few_);
        if (!high) return std::nullopt;
        slope_ = (high->y - low->y) / (high->x - low->x);
        if ((low->y > 0) == (high->y > 0)) {
            const Point& nearer = std::abs(low->y) < std::abs(high->y) ? *low : *high;
            return crossing(nearer, false);
        }
        const auto near = bracket(*low, *high);
        if (!near || !measure_slope(*near)) return std::nullopt;
        return refine(*near);
    }

  private:
    std::optional<Point> at(double x, std::uint32_t presentations) const {
        const auto counted = count_(std::exp(x), presentations);
        if (!counted) return std::nullopt;
        // Half a hit more and half a miss more keep the odds finite.
        const double share =
            (static_cast<double>(counted->hits) + 0.5) / (static_cast<double>(counted->of) + 1);
        return Point{x, *counted, log_odds(share) - log_odds(search_.target)};
    }

    double sd_of_share(std::uint64_t of) const {
        return std::sqrt(search_.target * (1 - search_.target) / static_cast<double>(of));
    }

    // False position, with the end that stays weighed half (Illinois).
    std::optional<Point> bracket(Point low, Point high) {
        constexpr int most_steps = 20;
        double low_y = low.y;
        double high_y = high.y;
        for (int i = 0; i < most_steps && high.x - low.x > 0.02; ++i) {
            const auto middle = at((low.x * high_y - high.x * low_y) / (high_y - low_y), few_);
            if (!middle) return std::nullopt;
            const bool as_low = (middle->y > 0) == (low.y > 0);
            Point& replaced = as_low ? low : high;
            replaced = *middle;
            low_y = as_low ? middle->y : low_y / 2;
            high_y = as_low ? high_y / 2 : middle->y;
            if (std::abs(middle->counted.value() - search_.target) < 0.5 * sd_of_share(few_)) return middle;
        }
        return std::abs(low.y) < std::abs(high.y) ? low : high;
    }

    // The slope at the crossing, where the chord of the whole range is too flat: it is measured where the
    // odds are a third more and less, or nearer. False: interrupted.
    bool measure_slope(const Point& near) {
        const double step = 0.3 / std::abs(slope_);
        const auto before = at(near.x - step, few_);
        if (!before) return false;
        const auto after = at(near.x + step, few_);
        if (!after) return false;
        const double measured = (after->y - before->y) / (after->x - before->x);
        // By chance alone it may come out flat or the other way round.
        if (measured * slope_ > 0) slope_ = measured;
        return true;
    }

    // Steps along the slope, with all presentations.
    std::optional<Crossing> refine(const Point& near) const {
        constexpr int most_steps = 8;
        std::optional<Point> best;
        double x = near.x;
        for (int i = 0; i < most_steps; ++i) {
            const auto point = at(x, search_.presentations);
            if (!point) return std::nullopt;
            if (!best || std::abs(point->y) < std::abs(best->y)) best = point;
            if (std::abs(point->counted.value() - search_.target) <= tolerance_) break;
            x = std::clamp(point->x - point->y / slope_, std::log(search_.low), std::log(search_.high));
        }
        return crossing(*best, true);
    }

    Crossing crossing(const Point& point, bool is_reached) const {
        // d share / d parameter = share (1 - share) slope / parameter
        const double parameter = std::exp(point.x);
        const double steepness = search_.target * (1 - search_.target) * std::abs(slope_) / parameter;
        return {parameter, point.counted, sd_of_share(point.counted.of) / steepness, is_reached};
    }

    const CrossingSearch& search_;
    const CountAt& count_;
    std::uint32_t few_;
    double tolerance_;
    double slope_ = 0;
};

}  // namespace

std::optional<Crossing> find_crossing(const CrossingSearch& search, const CountAt& count) {
    return Search(search, count).find();
}

}  // namespace afferent
