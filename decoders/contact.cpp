#include "afferent/decoders/contact.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// By this part of the highest pressure contacts differ from the shape that is fitted.
constexpr double misshapen = 0.03;
constexpr double area_of_fit = 1.1;

DecodedAfferents afferents_of(const ContactReadout::Parameters& parameters) {
    DecodedAfferents afferents{.addresses = parameters.addresses,
                               .largest_grip_n = 0,
                               .scan = parameters.scan,
                               .hysteresis = parameters.hysteresis,
                               .tick = parameters.tick,
                               .uncertainty = Uncertainty::none()};
    for (const ContactReadout::Afferent& afferent : parameters.afferents) {
        afferents.largest_grip_n = std::max(afferents.largest_grip_n, afferent.group.full_scale_n);
        afferents.add(afferent.address, afferent.group, 1);
    }
    return afferents;
}

std::vector<double> units_of(const ContactReadout::Parameters& parameters) {
    std::vector<double> units;
    for (const ContactReadout::Afferent& afferent : parameters.afferents)
        units.push_back(afferent.unit_n_per_mm2);
    return units;
}

std::vector<SkinField> fields_of(const ContactReadout::Parameters& parameters) {
    std::vector<SkinField> fields;
    for (const ContactReadout::Afferent& afferent : parameters.afferents) fields.push_back(afferent.field);
    return fields;
}

// As large as what the afferents can tell apart: the way from one to the next.
double usual_mm(const ContactReadout::Parameters& parameters) {
    const double skin_mm2 = static_cast<double>(parameters.elements.size()) * parameters.element_mm2;
    return std::sqrt(skin_mm2 / static_cast<double>(std::max<std::size_t>(1, parameters.afferents.size())));
}

}  // namespace

ContactReadout::ContactReadout(const Parameters& parameters)
    : patch_(parameters.patch),
      interval_(parameters.interval),
      pressures_(afferents_of(parameters), units_of(parameters)),
      fit_(fields_of(parameters), usual_mm(parameters)),
      elements_(parameters.elements),
      element_mm2_(parameters.element_mm2),
      readings_(parameters.afferents.size()) {
    require(interval_ > 0ns, "interval", "> 0", seconds(interval_));
    require(!elements_.empty(), "elements", "at least one", 0);
}

ContactReadout::Sums ContactReadout::sums_of(const PressureShape& shape) const noexcept {
    double sum = 0, squares = 0, x = 0, y = 0;
    for (const SkinField& element : elements_) {
        const double pressure = shape.read_by(element);
        sum += pressure;
        squares += pressure * pressure;
        x += pressure * element.x_mm;
        y += pressure * element.y_mm;
    }
    if (!(sum > 0)) return {};
    // An element has the mean of its pressure, which widens a narrow contact.
    const double width_mm2 = elements_.front().variance_mm2;
    const double narrow = std::sqrt(shape.major_mm2() * shape.minor_mm2() /
                                    ((shape.major_mm2() + width_mm2) * (shape.minor_mm2() + width_mm2)));
    return {sum * element_mm2_, x / sum, y / sum, area_of_fit * sum * sum / squares * element_mm2_ * narrow};
}

std::optional<PatchContact> ContactReadout::step(TimePoint now) {
    if (intervals_until(now) <= intervals_) return std::nullopt;
    intervals_ = intervals_until(now);
    return PatchContact{.time = now, .patch = patch_, .estimate = estimate(now)};
}

ContactEstimate ContactReadout::estimate(TimePoint now) {
    ContactEstimate estimate;
    estimate.afferents = pressures_.read(now, readings_);
    if (estimate.afferents == 0) return estimate;
    double highest = 0;
    for (const PressureFit::Reading& reading : readings_) highest = std::max(highest, reading.lowest);
    for (PressureFit::Reading& reading : readings_) {
        reading.below = std::hypot(reading.below, misshapen * highest);
        reading.above = std::hypot(reading.above, misshapen * highest);
    }
    const PressureFit::Solution solution = fit_(readings_);
    const PressureShape shape = fit_.shape(solution.values);
    const Sums sums = sums_of(shape);
    // Where the readings are further off than they should be, so is the contact.
    double misfit = 0;
    for (std::size_t i = 0; i < readings_.size(); ++i)
        if (readings_[i].lowest > 0) misfit += std::pow(readings_[i].off(shape.read_by(fit_.fields()[i])), 2);
    const double excess = std::max(1.0, misfit / estimate.afferents);
    Sums variance{};
    const auto add = [&variance](const Sums& one, const Sums& other, double weight) {
        const auto square = [weight](double a, double b) { return weight * (a - b) * (a - b); };
        variance.force_n += square(one.force_n, other.force_n);
        variance.x_mm += square(one.x_mm, other.x_mm);
        variance.y_mm += square(one.y_mm, other.y_mm);
        variance.area_mm2 += square(one.area_mm2, other.area_mm2);
    };
    fit_.each_deviation(solution, [&](const PressureShape& above, const PressureShape& below) {
        add(sums_of(above), sums_of(below), excess / 4);
    });
    estimate.force_n = sums.force_n;
    estimate.force_sigma_n = std::sqrt(variance.force_n);
    estimate.x_mm = sums.x_mm;
    estimate.x_sigma_mm = std::sqrt(variance.x_mm);
    estimate.y_mm = sums.y_mm;
    estimate.y_sigma_mm = std::sqrt(variance.y_mm);
    estimate.area_mm2 = sums.area_mm2;
    estimate.area_sigma_mm2 = std::sqrt(variance.area_mm2);
    return estimate;
}

std::size_t ContactReadout::bytes() const {
    return sizeof *this + pressures_.heap_bytes() + fit_.heap_bytes() +
           elements_.capacity() * sizeof(SkinField) +
           readings_.capacity() * sizeof(PressureFit::Reading);
}

}  // namespace afferent
