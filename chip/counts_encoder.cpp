#include "afferent/chip/counts_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "afferent/encoders/encoders.hpp"
#include "afferent/scene/scene_error.hpp"

namespace afferent {
namespace {

using Piece = CountsCurve::Piece;

constexpr std::size_t most_pieces = 1024;

// The input before it is rounded, and after.
struct Inputs {
    std::vector<double> exact;
    std::vector<std::int64_t> rounded;
};

// The quotient through the input at the begin, the middle and the last of so many counts. None where its
// coefficients do not fit.
bool fits(const Inputs& inputs, std::uint32_t begin, std::uint32_t length, Piece& piece) {
    const auto last = static_cast<double>(length - 1);
    const auto middle = static_cast<double>((length - 1) / 2);
    const std::span<const std::int64_t> rounded = std::span(inputs.rounded).subspan(begin, length);
    const std::int64_t offset = std::ranges::min(rounded);
    // A half is added, since the quotient is rounded down.
    const auto above = [&](double x) {
        return inputs.exact[begin + static_cast<std::uint32_t>(x)] - static_cast<double>(offset) + 0.5;
    };
    const double q = above(0);
    double p = 0;
    double s = 0;
    if (length > 1) {
        const double rise = above(last) - q;
        if (middle > 0 && above(last) != above(middle))
            s = (last * (above(middle) - q) / middle - rise) / (last * (above(last) - above(middle)));
        p = (rise + s * last * above(last)) / last;
    }
    const double largest = std::max({q, q + p * last, 1.0, 1 + s * last});
    if (!std::isfinite(largest) || std::min({q, q + p * last}) < 0 || 1 + s * last <= 0) return false;
    const int shift = 61 - std::ilogb(largest);
    const auto scaled = [&](double value) { return std::llround(std::ldexp(value, shift)); };
    piece = {begin, offset, scaled(p), scaled(q), scaled(s), scaled(1)};
    const auto is_equal = [&](std::uint32_t i) {
        const std::int64_t x = i;
        return piece.p * x + piece.q >= 0 && piece.s * x + piece.r > 0 &&
               piece.input(begin + i) == rounded[i];
    };
    for (std::uint32_t i = 0; i < length; ++i)
        if (!is_equal(i)) return false;
    return true;
}

// The longest piece from there on: twice as long as long as that fits, and then by bisection.
std::uint32_t longest(const Inputs& inputs, std::uint32_t begin, Piece& piece) {
    const auto left = static_cast<std::uint32_t>(inputs.exact.size()) - begin;
    std::uint32_t fitting = 1;
    std::uint32_t tried = 1;
    for (Piece found; tried <= left && fits(inputs, begin, tried, found);) {
        piece = found;
        fitting = tried;
        if (tried == left) return fitting;
        tried = std::min(left, 2 * tried);
    }
    while (tried - fitting > 1) {
        const std::uint32_t middle = fitting + (tried - fitting) / 2;
        Piece found;
        if (fits(inputs, begin, middle, found)) {
            piece = found;
            fitting = middle;
        } else {
            tried = middle;
        }
    }
    return fitting;
}

CountsCurve curve_of(const Inputs& inputs, const std::string& about) {
    const auto counts = static_cast<std::uint32_t>(inputs.exact.size());
    CountsCurve curve{.highest_count = counts - 1, .pieces = {}};
    for (std::uint32_t begin = 0; begin < counts;) {
        if (curve.pieces.size() == most_pieces)
            throw SceneError({about + "from counts to inputs takes more than " + std::to_string(most_pieces) +
                              " pieces: fewer neuron.fixed_point.state_bits or sensor.adc_bits take less"});
        begin += longest(inputs, begin, curve.pieces.emplace_back());
    }
    return curve;
}

Inputs inputs_of(const PatchPlan& patch, std::uint32_t element) {
    const FixedPointLif neuron(std::get<FixedPointParameters>(patch.neuron_of(element)));
    const Sustained encoder(std::get<Sustained::Parameters>(patch.encoder));
    Inputs inputs;
    for (const double force_n : forces_of_counts(patch, element)) {
        Sustained::State none;
        const double drive_mv = encoder.drive_mv(none, scene_start, force_n);
        inputs.exact.push_back(neuron.exact_input(drive_mv));
        inputs.rounded.push_back(neuron.input(drive_mv));
    }
    return inputs;
}

}  // namespace

std::int64_t CountsCurve::Piece::input(std::uint32_t counts) const noexcept {
    const std::int64_t x = counts - begin;
    return offset + (p * x + q) / (s * x + r);
}

std::int64_t CountsCurve::input(std::uint32_t counts) const noexcept {
    const std::uint32_t inside = std::min(counts, highest_count);
    return std::prev(std::ranges::upper_bound(pieces, inside, {}, &Piece::begin))->input(inside);
}

std::vector<double> forces_of_counts(const PatchPlan& patch, std::uint32_t element) {
    const scene::Sensor& sensor = patch.sensor;
    std::vector<double> forces_n(static_cast<std::size_t>(Sensor(sensor).highest_count()) + 1);
    const auto stuck = std::ranges::find(sensor.stuck_element, element, &scene::StuckElement::element);
    if (stuck != sensor.stuck_element.end()) {
        std::ranges::fill(forces_n, stuck->force_n);
    } else if (std::ranges::count(sensor.dead_element, element) == 0) {
        for (std::size_t i = 0; i < forces_n.size(); ++i) forces_n[i] = patch.force_n(static_cast<double>(i));
    }
    return forces_n;
}

CountsEncoder counts_encoder(const Plan& plan) {
    CountsEncoder encoder;
    for (const PatchPlan& patch : plan.patches) {
        const std::string about = plan.scene.file + ": patch \"" + patch.name + "\": ";
        if (!patch.proportional())
            throw SceneError(
                {about + "its encoder is not sustained {} without a dynamic term or slow adaptation"});
        if (!patch.owns_elements || !patch.fields.is_one_each())
            throw SceneError({about + "its afferents do not read one element of their own each"});
        const bool alike = patch.variations.empty() && patch.sensor.dead_element.empty() &&
                           patch.sensor.stuck_element.empty();
        for (std::uint32_t i = 0; i < patch.afferents(); ++i) {
            if (alike && i > 0) {
                encoder.curve.push_back(encoder.curve.back());
                continue;
            }
            const CountsCurve curve = curve_of(inputs_of(patch, i), about);
            const auto same = std::ranges::find(encoder.curves, curve);
            encoder.curve.push_back(static_cast<std::uint32_t>(same - encoder.curves.begin()));
            if (same == encoder.curves.end()) encoder.curves.push_back(curve);
        }
    }
    return encoder;
}

}  // namespace afferent
