#include "afferent/studies/trial/percent.hpp"

#include <cmath>
#include <iomanip>
#include <sstream>

namespace afferent {

double percent(const Proportion& proportion) { return 100 * proportion.value(); }

Summary known(double value) { return std::isfinite(value) ? Summary(value) : Summary(); }

void add_percent(Summary& summary, const std::string& name, const Proportion& proportion) {
    const Bounds interval = interval_95(proportion);
    summary[name + "_pct"] = known(percent(proportion));
    summary[name + "_low_pct"] = 100 * interval.low;
    summary[name + "_high_pct"] = 100 * interval.high;
}

Summary summary_of(const Estimated& estimated, double scale, const std::string& unit) {
    return {{"value" + unit, scale * estimated.value},
            {"low" + unit, scale * estimated.interval.low},
            {"high" + unit, scale * estimated.interval.high}};
}

std::string fixed(double value, int decimals) {
    if (!std::isfinite(value)) return "-";
    std::ostringstream text;
    text << std::fixed << std::setprecision(decimals) << value;
    return text.str();
}

std::string range_of(const Proportion& proportion) {
    const Bounds interval = interval_95(proportion);
    return fixed(100 * interval.low, 1) + " to " + fixed(100 * interval.high, 1);
}

std::string points(const Estimated& estimated) {
    const auto [low, high] = estimated.interval;
    return (estimated.value > 0 ? "+" : "") + fixed(100 * estimated.value, 2) + " (" + fixed(100 * low, 2) +
           " to " + fixed(100 * high, 2) + ")";
}

}  // namespace afferent
