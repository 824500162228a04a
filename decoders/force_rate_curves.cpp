#include "afferent/decoders/force_rate_curves.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "afferent/neurons/lif_models.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using Group = DecodedAfferents::Group;
using Points = std::vector<ForceRateCurve::Point>;

// Rates grow by 2 % from point to point, so that the error of linear interpolation is (2 %)²/8 of the
// curvature, 5e-5.
constexpr double lowest_hz = 0.1;
constexpr double growth = 1.02;
// Times are whole nanoseconds.
constexpr double highest_hz = 1e9;

// The flows from one spike to the next at the rates of the points. Nearly all of the time of a curve goes
// into them. The afferents of a population share them, and a scene that is checked, planned and built asks
// for the same ones each time: every thread keeps those that it has asked for last.
class FlowsByRate {
  public:
    // Valid until the next call.
    static FlowsByRate& of(RateKind kind, const LifParameters& neuron) {
        thread_local std::vector<FlowsByRate> kept;
        const auto known = std::find_if(kept.begin(), kept.end(), [&](const FlowsByRate& flows) {
            return flows.kind_ == kind && flow_alike(flows.neuron_, neuron);
        });
        if (known != kept.end()) {
            std::rotate(known, known + 1, kept.end());
        } else {
            if (kept.size() == most_kept) kept.erase(kept.begin());
            kept.push_back(FlowsByRate(kind, neuron));
        }
        return kept.back();
    }

    // To be asked for in the order of the points.
    const std::optional<Propagator>& at(std::size_t point, double rate_hz) {
        if (point == flows_.size()) flows_.push_back(lif_flow(kind_, neuron_, rate_hz));
        return flows_[point];
    }

  private:
    static constexpr std::size_t most_kept = 4;

    FlowsByRate(RateKind kind, const LifParameters& neuron) : kind_(kind), neuron_(neuron) {}

    RateKind kind_;
    LifParameters neuron_;
    std::vector<std::optional<Propagator>> flows_;
};

void add_points_by_rate(Points& points, const Group& group, const LifParameters& neuron, RateKind kind,
                        double largest_n) {
    FlowsByRate& flows = FlowsByRate::of(kind, neuron);
    std::size_t point = 0;
    for (double rate = lowest_hz; rate <= highest_hz; rate *= growth, ++point) {
        const double grip_n = group.grip_n(lif_drive_mv(neuron, flows.at(point, rate)));
        if (!(grip_n <= largest_n)) break;
        if (grip_n > points.back().force_n && rate > points.back().rate_hz) points.push_back({grip_n, rate});
    }
}

// Where the drive for a rate takes a search over simulations, points are set by force instead, one simulation
// each. The force above the threshold begins with a ten-thousandth of the range and grows by 5 % from point
// to point; rates grow no faster, so that interpolation errs by 3e-4 of the curvature, less than the ticks of
// a chip. Where the rate is constant and then steps up, so does the curve.
void add_points_by_force(Points& points, const Group& group, RateKind kind, double largest_n) {
    const double begin_n = points.back().force_n;
    const double range_n = largest_n - begin_n;
    double stays_until_n = begin_n;
    for (double above_n = range_n * 1e-4; above_n < range_n; above_n *= 1.05) {
        const double force_n = begin_n + above_n;
        const double rate = group.rate_hz(kind, force_n);
        const auto [last_n, last_rate] = points.back();
        if (!(force_n > last_n)) continue;
        if (rate > last_rate) {
            const double hardly_more = last_rate + 1e-6 * (rate - last_rate);
            if (stays_until_n > last_n && hardly_more > last_rate)
                points.push_back({stays_until_n, hardly_more});
            points.push_back({force_n, rate});
        }
        stays_until_n = force_n;
    }
}

Points computed_points(const Group& group, RateKind kind, double largest_n) {
    Points points;
    const double threshold_n = group.threshold_n();
    if (threshold_n >= 0)
        points.push_back({threshold_n, 0});
    else
        points.push_back({0, group.rate_hz(kind, 0)});
    if (const auto* neuron = std::get_if<LifParameters>(&group.neuron))
        add_points_by_rate(points, group, *neuron, kind, largest_n);
    else
        add_points_by_force(points, group, kind, largest_n);
    const double at_end = group.rate_hz(kind, largest_n);
    if (largest_n > points.back().force_n && at_end > points.back().rate_hz)
        points.push_back({largest_n, at_end});
    if (points.size() < 2)
        throw ParameterError("patch", "patches that fire within the range of their sensors",
                             "silent up to " + std::to_string(largest_n) + " N of grip force");
    return points;
}

// As FlowsByRate: simulations are not repeated for the points that a thread has asked for last.
Points points_of(const Group& group, RateKind kind, double largest_n) {
    if (std::holds_alternative<LifParameters>(group.neuron)) return computed_points(group, kind, largest_n);
    struct Kept {
        Group group;
        RateKind kind;
        double largest_n;
        Points points;
    };
    constexpr std::size_t most_kept = 4;
    thread_local std::vector<Kept> kept;
    const auto known = std::find_if(kept.begin(), kept.end(), [&](const Kept& each) {
        return each.group == group && each.kind == kind && each.largest_n == largest_n;
    });
    if (known != kept.end()) {
        std::rotate(known, known + 1, kept.end());
    } else {
        Points points = computed_points(group, kind, largest_n);
        if (kept.size() == most_kept) kept.erase(kept.begin());
        kept.push_back({group, kind, largest_n, std::move(points)});
    }
    return kept.back().points;
}

struct Crowd {
    const Group* group;
    std::uint32_t afferents;
};

// Where afferents differ one by one, so many of them, evenly spaced by address, stand for all. They are drawn
// independently of their addresses, so that the mean rate is off by a thirtieth of one afferent's spread.
constexpr std::size_t most_crowds = 1024;

// The groups whose afferents feel the grip force. An afferent without a share fires at its bias alone, which
// tells nothing about the grip.
std::vector<Crowd> crowds_of(const DecodedAfferents& decoded) {
    std::vector<std::uint32_t> sizes(decoded.groups.size(), 0);
    for (const auto& afferent : decoded.afferents)
        if (afferent.share != 0) ++sizes[afferent.group];
    std::vector<Crowd> crowds;
    for (std::size_t i = 0; i < sizes.size(); ++i)
        if (sizes[i] > 0) crowds.push_back({&decoded.groups[i], sizes[i]});
    return crowds;
}

// At most most_crowds, of as many afferents.
std::vector<Crowd> representatives(const std::vector<Crowd>& crowds) {
    if (crowds.size() <= most_crowds) return crowds;
    std::vector<Crowd> some;
    for (std::size_t i = 0; i < most_crowds; ++i) {
        const std::size_t begin = i * crowds.size() / most_crowds;
        const std::size_t end = (i + 1) * crowds.size() / most_crowds;
        some.push_back({crowds[(begin + end) / 2].group, 0});
        for (std::size_t each = begin; each < end; ++each) some.back().afferents += crowds[each].afferents;
    }
    return some;
}

}  // namespace

ForceRateCurve group_curve(const Group& group, RateKind kind, double largest_n) {
    return ForceRateCurve(points_of(group, kind, largest_n));
}

// Noise and the last step of a converter take up to this part of a full scale.
constexpr double full_scale_margin = 0.02;

double full_scale_fraction(const DecodedAfferents& afferents) {
    return (1 - full_scale_margin) * (1 - afferents.hysteresis);
}

FullScale full_scale_of(const DecodedAfferents& decoded) {
    const double part = full_scale_fraction(decoded);
    FullScale all{.rate_hz = 0};
    std::map<std::pair<double, double>, double> alike;  // by rheobase and drive at full scale
    for (const Crowd& crowd : representatives(crowds_of(decoded))) {
        const Group& group = *crowd.group;
        if (!std::isfinite(group.full_scale_n)) return {};
        all.rate_hz += crowd.afferents * group.rate_hz(RateKind::steady, part * group.full_scale_n);
        const double drive_mv = group.drive_mv_per_n * group.full_scale_n + group.bias_mv;
        alike[{rheobase_mv(group.neuron), std::round(1e6 * drive_mv)}] += crowd.afferents;
    }
    for (const auto& [key, count] : alike) all.counts_as += count * count;
    all.counts_as = std::sqrt(all.counts_as);
    double shares = 0;
    for (const auto& afferent : decoded.afferents) {
        if (afferent.share == 0) continue;
        shares += afferent.share;
        all.reading_n += afferent.share * decoded.groups[afferent.group].full_scale_n;
    }
    all.reading_n /= shares;
    return all;
}

ForceRateCurve pooled_curve(const DecodedAfferents& decoded, RateKind kind) {
    const double largest_n = decoded.largest_grip_n;
    const std::vector<Crowd> crowds = representatives(crowds_of(decoded));
    if (crowds.empty())
        throw ParameterError("patch", "at least one patch that it inverts and whose elements have a share",
                             "none");
    if (crowds.size() == 1) {
        const Group& group = *crowds.front().group;
        Points points = points_of(group, kind, std::min(largest_n, group.full_scale_n));
        for (auto& point : points) point.rate_hz *= crowds.front().afferents;
        return ForceRateCurve(std::move(points));
    }
    // The sum is evaluated at the forces at which any of the groups has a point, thinned out to at most 512.
    std::vector<ForceRateCurve> curves;
    std::vector<double> forces_n;
    for (const Crowd& crowd : crowds) {
        curves.push_back(group_curve(*crowd.group, kind, largest_n));
        for (const auto& point : curves.back().points()) forces_n.push_back(point.force_n);
    }
    std::sort(forces_n.begin(), forces_n.end());
    const std::size_t stride = forces_n.size() / 512 + 1;
    Points points;
    for (std::size_t i = 0; i < forces_n.size(); i += stride) {
        double sum_hz = 0;
        for (std::size_t j = 0; j < crowds.size(); ++j) {
            const double felt_n = std::min(forces_n[i], crowds[j].group->full_scale_n);
            sum_hz += crowds[j].afferents * curves[j].rate_hz(felt_n);
        }
        if (points.empty() || (forces_n[i] > points.back().force_n && sum_hz > points.back().rate_hz))
            points.push_back({forces_n[i], sum_hz});
    }
    return ForceRateCurve(std::move(points));
}

}  // namespace afferent
