#include "afferent/decoders/contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// By this part of the highest pressure contacts differ from the shape that is fitted.
constexpr double misshapen = 0.03;
constexpr double area_of_fit = 1.1;
// By these parts force and area are off where the shape alone is not as fitted.
constexpr double force_of_shape = 0.02;
constexpr double area_of_shape = 0.06;
// By this part a velocity is off where pressures rise and fall as well.
constexpr double velocity_of_change = 0.1;
// Where a contact has the fitted shape, its readings are off by this part of their deviations.
constexpr double usually_off = 0.5;
// What a fit hides of the readings' scatter is taken for this many times what is left, at most.
constexpr double most_hidden = 3;
// An element that reads this part of full scale may feel more: as much again, as a standard deviation.
constexpr double near_full_scale = 0.9;
// Two contacts explain this much of the readings' squared misfits that one does not. Chance alone gives less
// than the first in 999 of 1000 cases (χ², six degrees of freedom). The second is added for shapes unlike
// Hertz's, as far as these are what makes the readings uncertain. All of it is added where two do not fit as
// contacts usually do: dead elements scatter the readings, and two shapes follow the scatter better than one.
constexpr double surely_two = 23;
constexpr double surely_two_of_shapes = 37;
// A contact slides where a velocity explains more than this. Chance alone gives less in 999 of 1000 cases
// (χ², two degrees of freedom).
constexpr double surely_moves = 14;
// Alternating between two contacts, each is fitted to what the other leaves.
constexpr int alternations = 6;
constexpr int most_divisions = 8;

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

// The lowest pressure at which an element is at full scale.
double full_scale_of(const ContactReadout::Parameters& parameters) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const ContactReadout::Afferent& afferent : parameters.afferents)
        lowest = std::min(lowest, afferent.group.full_scale_n * afferent.unit_n_per_mm2);
    return lowest;
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
      pressures_(afferents_of(parameters), units_of(parameters), fields_of(parameters),
                 parameters.transients),
      fit_(fields_of(parameters), usual_mm(parameters)),
      elements_(parameters.elements),
      element_mm2_(parameters.element_mm2),
      full_scale_(full_scale_of(parameters)),
      readings_(parameters.afferents.size()),
      rest_(readings_.size()),
      at_their_times_(2 * readings_.size()),
      side_(readings_.size()) {
    require(interval_ > 0ns, "interval", "> 0", seconds(interval_));
    require(!elements_.empty(), "elements", "at least one", 0);
}

ContactReadout::Sums ContactReadout::sums_of(const PressureShape& shape) const noexcept {
    double sum = 0, squares = 0, x = 0, y = 0, full = 0;
    for (const SkinField& element : elements_) {
        const double pressure = shape.read_by(element);
        sum += pressure;
        squares += pressure * pressure;
        x += pressure * element.x_mm;
        y += pressure * element.y_mm;
        if (pressure >= near_full_scale * full_scale_) full += pressure;
    }
    if (!(sum > 0)) return {};
    // An element has the mean of its pressure, which widens a narrow contact.
    const double width_mm2 = elements_.front().variance_mm2;
    const double narrow = std::sqrt(shape.major_mm2() * shape.minor_mm2() /
                                    ((shape.major_mm2() + width_mm2) * (shape.minor_mm2() + width_mm2)));
    return {sum * element_mm2_, x / sum, y / sum, area_of_fit * sum * sum / squares * element_mm2_ * narrow,
            full * element_mm2_};
}

std::span<const PatchContact> ContactReadout::step(TimePoint now) {
    if (intervals_until(now) <= intervals_) return {};
    intervals_ = intervals_until(now);
    return contacts(now);
}

ContactReadout::Fitted ContactReadout::fit(Readings readings, bool moves) const noexcept {
    const PressureFit::Solution solution = fit_(readings, moves);
    return {solution, fit_.shape(solution.values)};
}

void ContactReadout::blur(std::span<PressureFit::Reading> readings, double highest) noexcept {
    for (PressureFit::Reading& reading : readings) {
        reading.below = std::hypot(reading.below, misshapen * highest);
        reading.above = std::hypot(reading.above, misshapen * highest);
    }
}

double ContactReadout::read_by(std::span<const Fitted> contacts, std::size_t reading,
                               double age_s) const noexcept {
    const SkinField& field = fit_.fields()[reading % fit_.fields().size()];
    double pressure = 0;
    for (const Fitted& contact : contacts) pressure += contact.shape.read_by(field, age_s);
    return pressure;
}

double ContactReadout::misfit(Readings readings, std::span<const Fitted> contacts, bool felt) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        if (felt && !(readings[i].lowest > 0)) continue;
        const double off = readings[i].off(read_by(contacts, i, readings[i].age_s));
        sum += off * off;
    }
    return sum;
}

// A contact that stands may have had a common change; one that moves is taken to have had none.
std::optional<ContactReadout::Moving> ContactReadout::fit_moving(TimePoint now,
                                                                 const CommonChange::Factor& change,
                                                                 const Fitted& one, double highest) noexcept {
    const auto read = [&](const CommonChange::Factor& changed) {
        pressures_.read_at_their_times(now, at_their_times_, changed);
        blur(at_their_times_, highest);
    };
    const auto off = [&](const Fitted& fitted) { return fit_.misfit(at_their_times_, fitted.shape); };
    read(change);
    // A velocity lowers the misfit to 0 at most.
    if (off(one) <= surely_moves) return std::nullopt;
    const double standing = off(fit(at_their_times_));
    read({});
    const Fitted moving = fit(at_their_times_, true);
    const double left = off(moving);
    if (!(standing - left > surely_moves)) return std::nullopt;
    return Moving{moving, left};
}

// A part d of the elements that is dead takes d of each reading on average, and scatters them by d(1 − d)/n
// of their squares, where each reads n elements.
ContactReadout::Doubt ContactReadout::doubt(Readings readings, std::span<const Fitted> contacts,
                                            std::uint32_t felt, std::size_t followed) const noexcept {
    // Where there are few readings that the fit does not follow, these tell little.
    const double hidden = felt / std::max(felt / most_hidden, felt - static_cast<double>(followed));
    double scatter = 0, squares = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const PressureFit::Reading& reading = readings[i];
        if (!(reading.lowest > 0)) continue;
        const double pressure = read_by(contacts, i, reading.age_s);
        const double sigma = pressure > reading.highest ? reading.above : reading.below;
        const double off = reading.off(pressure) * sigma;
        const double usual = usually_off * sigma;
        const double elements = 4 * std::numbers::pi * fit_.fields()[i].variance_mm2 / element_mm2_;
        scatter += std::max(1.0, elements) * (hidden * off * off - usual * usual);
        squares += pressure * pressure;
    }
    const double product = squares > 0 ? std::clamp(scatter / squares, 0.0, 0.25) : 0;
    const double dead = (1 - std::sqrt(1 - 4 * product)) / 2;
    // Where the readings are further off than they should be, so is the contact.
    return {std::max(1.0, misfit(readings, contacts, true) / felt), dead / (1 - dead)};
}

bool ContactReadout::divide() noexcept {
    double sum = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    const auto fields = fit_.fields();
    for (std::size_t i = 0; i < fields.size(); ++i) {
        sum += readings_[i].lowest;
        x += readings_[i].lowest * fields[i].x_mm;
        y += readings_[i].lowest * fields[i].y_mm;
    }
    x /= sum;
    y /= sum;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        const double part = readings_[i].lowest / sum;
        xx += part * (fields[i].x_mm - x) * (fields[i].x_mm - x);
        xy += part * (fields[i].x_mm - x) * (fields[i].y_mm - y);
        yy += part * (fields[i].y_mm - y) * (fields[i].y_mm - y);
    }
    // The middles begin one standard deviation off along the longer axis.
    const double angle = std::atan2(2 * xy, xx - yy) / 2;
    const double length = std::sqrt((xx + yy) / 2 + std::hypot((xx - yy) / 2, xy));
    const double dx = length * std::cos(angle);
    const double dy = length * std::sin(angle);
    double middle_x[2]{x - dx, x + dx};
    double middle_y[2]{y - dy, y + dy};
    for (int i = 0; i < most_divisions; ++i) {
        double sums[2]{}, sums_x[2]{}, sums_y[2]{};
        for (std::size_t k = 0; k < fields.size(); ++k) {
            const auto square = [&](int side) {
                const double to_x = fields[k].x_mm - middle_x[side];
                const double to_y = fields[k].y_mm - middle_y[side];
                return to_x * to_x + to_y * to_y;
            };
            side_[k] = square(1) < square(0);
            sums[side_[k]] += readings_[k].lowest;
            sums_x[side_[k]] += readings_[k].lowest * fields[k].x_mm;
            sums_y[side_[k]] += readings_[k].lowest * fields[k].y_mm;
        }
        if (!(sums[0] > 0 && sums[1] > 0)) return false;
        for (int side = 0; side < 2; ++side) {
            middle_x[side] = sums_x[side] / sums[side];
            middle_y[side] = sums_y[side] / sums[side];
        }
    }
    return true;
}

std::optional<std::array<ContactReadout::Fitted, 2>> ContactReadout::fit_two(const Fitted& one) noexcept {
    if (!divide()) return std::nullopt;
    std::array<Fitted, 2> two{one, one};
    for (std::size_t side = 0; side < 2; ++side) {
        rest_ = readings_;
        for (std::size_t i = 0; i < rest_.size(); ++i)
            if (side_[i] != side && rest_[i].lowest > 0) {
                rest_[i].lowest = 0;
                rest_[i].highest = std::numeric_limits<double>::infinity();
            }
        two[side] = fit(rest_);
    }
    for (int i = 0; i < 2 * alternations; ++i) {
        const PressureShape& other = two[(i + 1) % 2].shape;
        bool feels = false;
        for (std::size_t k = 0; k < rest_.size(); ++k) {
            const double pressure = other.read_by(fit_.fields()[k]);
            rest_[k] = readings_[k];
            rest_[k].lowest -= pressure;
            rest_[k].highest -= pressure;
            feels = feels || rest_[k].lowest > 0;
        }
        if (!feels) return std::nullopt;
        two[i % 2] = fit(rest_);
    }
    return two;
}

std::span<const PatchContact> ContactReadout::contacts(TimePoint now) {
    told_.fill({.time = now, .patch = patch_});
    const CommonChange::Factor change = pressures_.change(now);
    const std::uint32_t afferents = pressures_.read(now, readings_, change);
    if (afferents == 0) return std::span(told_).first(1);
    double highest = 0;
    for (const PressureFit::Reading& reading : readings_) highest = std::max(highest, reading.lowest);
    double of_shape = 0;  // of the variance of a reading, on average
    blur(readings_, highest);
    for (const PressureFit::Reading& reading : readings_)
        if (reading.lowest > 0) of_shape += std::pow(misshapen * highest / reading.below, 2) / afferents;
    const Fitted one = fit(readings_);
    const double of_one = misfit(readings_, {&one, 1}, false);
    const auto moving = fit_moving(now, change, one, highest);
    pressures_.take_for_sliding(moving.has_value());
    const double common_sigma = pressures_.common_sigma(now, change);
    const auto are_two = [&](std::span<const Fitted> two) {
        const bool fits = misfit(readings_, two, true) <= usually_off * usually_off * afferents;
        const double of_two = misfit(readings_, two, false);
        return of_one - of_two > surely_two + surely_two_of_shapes * (fits ? of_shape : 1) &&
               (!moving || of_two < moving->misfit);
    };
    if (of_one > surely_two)
        if (const auto two = fit_two(one); two && are_two(*two)) {
            for (std::size_t i = 0; i < 2; ++i)
                told_[i].estimate =
                    estimate((*two)[i], doubt(readings_, *two, afferents, 2 * PressureShape::at_present),
                             common_sigma);
            // An afferent is counted where it feels more.
            for (std::size_t i = 0; i < readings_.size(); ++i)
                if (readings_[i].lowest > 0) {
                    const SkinField& field = fit_.fields()[i];
                    const bool second = (*two)[1].shape.read_by(field) > (*two)[0].shape.read_by(field);
                    ++told_[second ? 1 : 0].estimate.afferents;
                }
            if (told_[0].estimate.afferents > 0 && told_[1].estimate.afferents > 0) {
                if (told_[1].estimate.force_n > told_[0].estimate.force_n) std::swap(told_[0], told_[1]);
                told_[1].contact = 1;
                return told_;
            }
        }
    if (moving) {
        const Doubt doubted =
            doubt(at_their_times_, {&moving->fitted, 1}, afferents, PressureShape::parameters);
        told_[0].estimate = estimate(moving->fitted, doubted);
        add_velocity(moving->fitted, doubted, told_[0].estimate);
    } else {
        told_[0].estimate =
            estimate(one, doubt(readings_, {&one, 1}, afferents, PressureShape::at_present), common_sigma);
    }
    told_[0].estimate.afferents = afferents;
    return std::span(told_).first(1);
}

ContactEstimate ContactReadout::estimate(const Fitted& fitted, const Doubt& doubt,
                                         double common_sigma) const noexcept {
    const Sums sums = sums_of(fitted.shape);
    Sums variance{};
    fit_.each_deviation(fitted.solution, [&](const PressureShape& above, const PressureShape& below) {
        const Sums a = sums_of(above);
        const Sums b = sums_of(below);
        const auto square = [&](double one, double other) {
            return doubt.excess / 4 * (one - other) * (one - other);
        };
        variance.force_n += square(a.force_n, b.force_n);
        variance.x_mm += square(a.x_mm, b.x_mm);
        variance.y_mm += square(a.y_mm, b.y_mm);
        variance.area_mm2 += square(a.area_mm2, b.area_mm2);
    });
    const double of_shape = std::hypot(force_of_shape, doubt.unfelt, common_sigma) * sums.force_n;
    return {.force_n = sums.force_n,
            .force_sigma_n = std::hypot(std::sqrt(variance.force_n), of_shape, sums.full_n),
            .x_mm = sums.x_mm,
            .x_sigma_mm = std::sqrt(variance.x_mm),
            .y_mm = sums.y_mm,
            .y_sigma_mm = std::sqrt(variance.y_mm),
            .area_mm2 = sums.area_mm2,
            .area_sigma_mm2 = std::hypot(std::sqrt(variance.area_mm2), area_of_shape * sums.area_mm2)};
}

void ContactReadout::add_velocity(const Fitted& fitted, const Doubt& doubt,
                                  ContactEstimate& estimate) noexcept {
    estimate.slides = true;
    estimate.velocity_x_mm_per_s = fitted.solution.values[PressureShape::vx];
    estimate.velocity_y_mm_per_s = fitted.solution.values[PressureShape::vy];
    const double of_change =
        velocity_of_change * std::hypot(estimate.velocity_x_mm_per_s, estimate.velocity_y_mm_per_s);
    const auto sigma = [&](std::size_t parameter) {
        double variance = of_change * of_change;
        for (const double each : fitted.solution.deviation[parameter]) variance += doubt.excess * each * each;
        return std::sqrt(variance);
    };
    estimate.velocity_x_sigma_mm_per_s = sigma(PressureShape::vx);
    estimate.velocity_y_sigma_mm_per_s = sigma(PressureShape::vy);
}

std::size_t ContactReadout::bytes() const {
    return sizeof *this + pressures_.heap_bytes() + fit_.heap_bytes() +
           elements_.capacity() * sizeof(SkinField) +
           (readings_.capacity() + rest_.capacity() + at_their_times_.capacity()) *
               sizeof(PressureFit::Reading) +
           side_.capacity();
}

}  // namespace afferent
