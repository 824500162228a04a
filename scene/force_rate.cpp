#include "afferent/scene/force_rate.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Neurons that fire alike under a grip force: drive = slope · grip + bias.
struct Group {
    const NeuronParameters* neuron;
    double slope_mv_per_n;
    double bias_mv;
    std::uint32_t neurons;

    bool alike(const Group& other) const {
        return *neuron == *other.neuron && slope_mv_per_n == other.slope_mv_per_n && bias_mv == other.bias_mv;
    }
    double grip_n(double drive) const { return (drive - bias_mv) / slope_mv_per_n; }
};

// An element without a share feels nothing, and fires at its bias alone: it tells nothing of the grip.
std::vector<Group> groups(const Scene& scene) {
    std::vector<Group> all;
    for (const Patch& patch : scene.patches()) {
        if (!decodes(scene, patch)) continue;
        for (const double share : patch.share) {
            if (share == 0) continue;
            const Group group{&patch.neuron, patch.gain() * share, patch.bias_mv(), 1};
            const auto same =
                std::find_if(all.begin(), all.end(), [&](const Group& g) { return g.alike(group); });
            if (same == all.end())
                all.push_back(group);
            else
                ++same->neurons;
        }
    }
    return all;
}

RateKind curve_kind(const Scene& scene) {
    return scene.description().decoder().curve() == proto::ONSET ? RateKind::onset : RateKind::steady;
}

// Rates grow by 2 %, so that linear interpolation is good to (2 %)²/8 of the curvature, 5e-5.
constexpr double lowest_hz = 0.1;
constexpr double growth = 1.02;

// The points of one group, without a search: the drive for a rate is a formula.
std::vector<ForceRateCurve::Point> points_of(const Group& group, RateKind kind, double largest_n) {
    std::vector<ForceRateCurve::Point> points;
    const double begin_n = group.grip_n(group.neuron->rheobase_mv());
    if (begin_n >= 0)
        points.push_back({begin_n, 0});
    else
        points.push_back({0, rate_hz(kind, *group.neuron, group.bias_mv)});
    for (double rate = lowest_hz;; rate *= growth) {
        const double grip_n = group.grip_n(drive_mv(kind, *group.neuron, rate));
        if (!(grip_n <= largest_n)) break;
        if (grip_n > points.back().force_n && rate > points.back().rate_hz) points.push_back({grip_n, rate});
    }
    const double at_end = rate_hz(kind, *group.neuron, group.slope_mv_per_n * largest_n + group.bias_mv);
    if (largest_n > points.back().force_n && at_end > points.back().rate_hz)
        points.push_back({largest_n, at_end});
    if (points.size() < 2)
        throw ParameterError("patch", "patches that fire within the range of their sensors",
                             "silent up to " + std::to_string(largest_n) + " N of grip force");
    return points;
}

}  // namespace

bool decodes(const Scene& scene, const Patch& patch) {
    const auto& names = scene.description().decoder().patch();
    if (names.empty()) return patch.sustained();
    return std::find(names.begin(), names.end(), patch.name) != names.end();
}

std::vector<bool> read_addresses(const Scene& scene) {
    std::vector<bool> read(scene.addresses(), false);
    for (const Patch& patch : scene.patches())
        if (decodes(scene, patch)) std::fill_n(read.begin() + patch.first, patch.elements, true);
    return read;
}

double largest_grip_n(const Scene& scene) {
    double largest = 0;
    for (const Patch& patch : scene.patches())
        if (decodes(scene, patch))
            for (const double share : patch.share)
                if (share > 0)
                    largest = std::max(largest, scene.patches()[patch.reads].sensor.full_scale_n / share);
    return largest;
}

ForceRateCurve pooled_curve(const Scene& scene) {
    const RateKind kind = curve_kind(scene);
    const double largest_n = largest_grip_n(scene);
    const std::vector<Group> all = groups(scene);
    if (all.empty()) throw ParameterError("patch", "at least one patch whose elements have a share", "none");
    if (all.size() == 1) {
        std::vector<ForceRateCurve::Point> points = points_of(all.front(), kind, largest_n);
        for (auto& point : points) point.rate_hz *= all.front().neurons;
        return ForceRateCurve(std::move(points));
    }
    // The sum is evaluated where any one of them has a point, at up to 512 forces.
    std::vector<double> forces_n;
    for (const Group& group : all)
        for (const auto& point : points_of(group, kind, largest_n)) forces_n.push_back(point.force_n);
    std::sort(forces_n.begin(), forces_n.end());
    const std::size_t stride = forces_n.size() / 512 + 1;
    std::vector<ForceRateCurve::Point> points;
    for (std::size_t i = 0; i < forces_n.size(); i += stride) {
        double sum_hz = 0;
        for (const Group& group : all)
            sum_hz += group.neurons *
                      rate_hz(kind, *group.neuron, group.slope_mv_per_n * forces_n[i] + group.bias_mv);
        if (points.empty() || (forces_n[i] > points.back().force_n && sum_hz > points.back().rate_hz))
            points.push_back({forces_n[i], sum_hz});
    }
    return ForceRateCurve(std::move(points));
}

GripEstimator make_estimator(const Scene& scene) {
    if (scene.description().decoder().pooling() == proto::POOLED) {
        std::uint32_t neurons = 0;
        for (const Patch& patch : scene.patches()) neurons += decodes(scene, patch) ? patch.elements : 0;
        return {pooled_curve(scene), neurons};
    }
    const std::vector<Group> all = groups(scene);
    std::vector<ForceRateCurve> curves;
    for (const Group& group : all)
        curves.emplace_back(points_of(group, curve_kind(scene), largest_grip_n(scene)));
    std::vector<GripEstimator::Neuron> neurons;
    for (const Patch& patch : scene.patches()) {
        if (!decodes(scene, patch)) continue;
        for (std::uint32_t i = 0; i < patch.elements; ++i) {
            const Group group{&patch.neuron, patch.gain() * patch.share[i], patch.bias_mv(), 1};
            const auto same =
                std::find_if(all.begin(), all.end(), [&](const Group& g) { return g.alike(group); });
            if (same == all.end()) continue;
            neurons.push_back(
                {patch.first + i, static_cast<std::uint32_t>(same - all.begin()), patch.share[i]});
        }
    }
    return {std::move(curves), std::move(neurons)};
}

}  // namespace afferent
