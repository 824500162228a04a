#include "afferent/scene/afferents.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "afferent/hand/aperture.hpp"
#include "afferent/hand/random.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/patch_plan.hpp"

namespace afferent {
namespace {

constexpr double most_deviations = 4;
// Exponentials to compute for all fields of a patch: a few seconds.
constexpr double most_field_cells = 1U << 28;
// In pitches. The mean of narrower weights lies nearer to an element than the afferent does.
constexpr double least_weight_sd = 0.5;
// As close to threshold as a neuron may begin.
constexpr double latest_phase = 0.999;

double lowest_of(const scene::Distribution& distribution) {
    return std::visit(
        Overloaded{[](const scene::Normal& normal) { return normal.mean - most_deviations * normal.sd; },
                   [](const scene::LogNormal& log_normal) {
                       return log_normal.median * std::exp(-most_deviations * log_normal.sigma);
                   },
                   [](const scene::Uniform& uniform) { return uniform.lowest; }},
        distribution);
}

void check_distribution(const scene::Distribution& distribution, const std::string& field, bool is_factor) {
    if (const auto* uniform = std::get_if<scene::Uniform>(&distribution))
        require(uniform->highest >= uniform->lowest, (field + ".uniform.highest").c_str(), ">= lowest",
                uniform->highest);
    const double lowest = lowest_of(distribution);
    if (is_factor) require(lowest > 0, field.c_str(), "> 0 in all its values", lowest);
}

// The number of an afferent.
class Draw {
  public:
    Draw(const std::optional<scene::Distribution>& distribution, Stream stream, AfferentSeed seed)
        : distribution_(distribution), stream_(stream), seed_(seed) {}

    double operator()(std::uint32_t afferent, double if_none) const {
        if (!distribution_) return if_none;
        const Address address = seed_.first + afferent;
        const auto deviations = [&] {
            return std::clamp(gaussian(seed_.seed, stream_, address, 0), -most_deviations, most_deviations);
        };
        return std::visit(
            Overloaded{[&](const scene::Normal& normal) { return normal.mean + normal.sd * deviations(); },
                       [&](const scene::LogNormal& log_normal) {
                           return log_normal.median * std::exp(log_normal.sigma * deviations());
                       },
                       [&](const scene::Uniform& range) {
                           return std::lerp(range.lowest, range.highest,
                                            uniform(seed_.seed, stream_, address, 0));
                       }},
            *distribution_);
    }

  private:
    std::optional<scene::Distribution> distribution_;
    Stream stream_;
    AfferentSeed seed_;
};

LifParameters varied_lif(LifParameters neuron, const Variation& variation,
                         const std::vector<scene::TimeClass>& classes) {
    neuron.v_th_mv = neuron.v_r_mv + variation.threshold * (neuron.v_th_mv - neuron.v_r_mv);
    neuron.delta_g *= variation.delta_g;
    if (!classes.empty()) {
        neuron.tau_m_ms *= classes[variation.time_class].tau_m;
        neuron.tau_g_ms *= classes[variation.time_class].tau_g;
    }
    return neuron;
}

}  // namespace

void check(const scene::Spread& spread) {
    if (spread.gain) check_distribution(*spread.gain, "gain", true);
    if (spread.threshold) check_distribution(*spread.threshold, "threshold", true);
    if (spread.delta_g) check_distribution(*spread.delta_g, "delta_g", true);
    if (spread.field_sd) check_distribution(*spread.field_sd, "field_sd", true);
    if (spread.phase) check_distribution(*spread.phase, "phase", false);
}

Outline outline_of(const scene::Outline& outline) {
    return std::visit(
        Overloaded{[](const scene::Rectangle& rectangle) -> Outline {
                       return {Outline::Shape::rectangle, rectangle.width_mm, rectangle.height_mm};
                   },
                   [](const scene::Ellipse& ellipse) -> Outline {
                       return {Outline::Shape::ellipse, ellipse.width_mm, ellipse.height_mm};
                   }},
        outline.shape);
}

std::vector<Position> places_of(const scene::Afferents& afferents, const Outline& outline,
                                AfferentSeed seed) {
    if (!afferents.place.empty()) {
        for (const Position& place : afferents.place)
            if (!outline.contains(place))
                throw ParameterError("place", "within the outline",
                                     std::to_string(place.x_mm) + ", " + std::to_string(place.y_mm));
        return afferents.place;
    }
    return jittered_lattice(outline, afferents.per_cm2, afferents.jitter, scene::most_addresses,
                            [&](std::uint32_t index, std::uint32_t axis) {
                                return uniform(seed.seed, Stream::afferent_place, seed.first + index, axis);
                            });
}

double narrowest_field_sd_mm(double pitch_mm) { return pitch_mm * std::hypot(Aperture::sd, least_weight_sd); }

FieldRows gaussian_fields(const scene::Afferents& afferents, const std::vector<Position>& places,
                          const scene::Spread& spread, const ElementGrid& grid, AfferentSeed seed) {
    const Draw factor(spread.field_sd, Stream::afferent_field, seed);
    // The elements' aperture is a part of the field, whose variances add up.
    const auto weight_sd = [&](double field_sd_mm) {
        const double field_sd = field_sd_mm / grid.pitch_mm();
        return std::sqrt(
            std::max(field_sd * field_sd - Aperture::sd * Aperture::sd, least_weight_sd * least_weight_sd));
    };
    double cells = 0;
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        const double field_sd_mm = afferents.field_sd_mm * factor(i, 1);
        cells += std::pow(6 * weight_sd(field_sd_mm) + 1, 2);
        require(cells <= most_field_cells, "field_sd_mm",
                "so small that all fields of the patch together reach at most 2^28 elements", field_sd_mm);
    }
    FieldRows rows;
    rows.reserve(places.size(), static_cast<std::size_t>(cells));
    for (std::uint32_t i = 0; i < places.size(); ++i)
        grid.add_gaussian_field(places[i], weight_sd(afferents.field_sd_mm * factor(i, 1)) * grid.pitch_mm(),
                                rows);
    return rows;
}

FieldRows fields_of_one_each(std::uint32_t elements) {
    FieldRows rows;
    rows.reserve(elements, elements);
    for (std::uint32_t i = 0; i < elements; ++i) {
        rows.add({i, 1});
        rows.end_row();
    }
    return rows;
}

void spread_gain(FieldRows& rows, const scene::Spread& spread, AfferentSeed seed) {
    if (!spread.gain) return;
    const Draw factor(spread.gain, Stream::afferent_gain, seed);
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        const double gain = factor(i, 1);
        for (FieldWeight& weight : rows[i]) weight.weight *= gain;
    }
}

std::vector<Variation> variations_of(const scene::Spread& spread, std::uint32_t afferents,
                                     AfferentSeed seed) {
    if (!spread.threshold && !spread.delta_g && spread.time_class.empty()) return {};
    double parts = 0;
    for (const scene::TimeClass& each : spread.time_class) parts += each.part;
    const auto class_of = [&](std::uint32_t afferent) {
        double left = parts * uniform(seed.seed, Stream::afferent_time_class, seed.first + afferent, 0);
        std::uint32_t found = 0;
        while (found + 1 < spread.time_class.size() && left >= spread.time_class[found].part)
            left -= spread.time_class[found++].part;
        return found;
    };
    const Draw threshold(spread.threshold, Stream::afferent_threshold, seed);
    const Draw delta_g(spread.delta_g, Stream::afferent_delta_g, seed);
    std::vector<Variation> variations(afferents);
    for (std::uint32_t i = 0; i < afferents; ++i)
        variations[i] = {.threshold = threshold(i, 1), .delta_g = delta_g(i, 1), .time_class = class_of(i)};
    return variations;
}

Phases phases_of(const scene::Spread& spread, AfferentSeed seed) {
    if (!spread.phase) return {};
    return [draw = Draw(spread.phase, Stream::afferent_phase, seed)](std::uint32_t afferent) {
        return std::clamp(draw(afferent, 0), 0.0, latest_phase);
    };
}

std::string differences(const scene::Spread& spread, bool has_positions) {
    std::string all;
    const auto name = [&](bool differs, const char* what) {
        if (differs) all += (all.empty() ? "" : ", ") + std::string(what);
    };
    name(spread.gain.has_value(), "gain");
    name(spread.threshold.has_value(), "threshold");
    name(spread.delta_g.has_value(), "delta_g");
    name(spread.field_sd.has_value() && has_positions, "field_sd");
    name(spread.phase.has_value(), "phase");
    name(!spread.time_class.empty(), "time constants");
    return all;
}

NeuronModel varied(const NeuronModel& neuron, const Variation& variation,
                   const std::vector<scene::TimeClass>& classes) {
    if (const auto* lif = std::get_if<LifParameters>(&neuron)) return varied_lif(*lif, variation, classes);
    FixedPointParameters chip = std::get<FixedPointParameters>(neuron);
    chip.lif = varied_lif(chip.lif, variation, classes);
    return chip;
}

}  // namespace afferent
