// One contact with the skin, fitted to the pressures under receptive fields that lie here and there on it.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace afferent {

// A receptive field: where its middle is, and its variance in each direction.
struct SkinField {
    double x_mm, y_mm, variance_mm2;
    friend bool operator==(const SkinField&, const SkinField&) = default;
};

// A pressure that falls off from its middle c like a Gaussian of the covariance S, in any unit:
//
//     p(x) = P exp(−½ (x − c)ᵀ S⁻¹ (x − c)),      S = exp [m + d, e; e, m − d]
//
// Long and narrow it is an edge, which ends only where the skin does. A Gaussian field of the variance s²
// reads the same with S + s², and less of it by √(|S|/|S + s²|): the width of the fields is taken out of the
// fit by this, and not afterwards. It may move, at the velocity v: at an age, so long before the present, its
// middle was at c − v age.
class PressureShape {
  public:
    // ln P as a field of the mean variance reads it, which is known better than P; the middle in mm; the
    // logarithm of S; the velocity in mm/s.
    enum { log_peak, x, y, m, d, e, vx, vy, parameters };
    static constexpr std::size_t at_present = vx;  // of the parameters: those before the velocity
    using Values = std::array<double, parameters>;

    PressureShape(const Values& values, double mean_variance_mm2) noexcept;

    double read_by(const SkinField& field, double age_s = 0) const noexcept;
    // The eigenvalues of S.
    double major_mm2() const noexcept { return major_; }
    double minor_mm2() const noexcept { return minor_; }

  private:
    double peak_, x_, y_, vx_, vy_, major_, minor_, cos_, sin_;
};

// Least squares, with a prior of what a contact is like, which counts where few fields tell of it. Allocates
// nothing after construction.
class PressureFit {
  public:
    // A pressure within `lowest` and `highest`, which are off by a standard deviation of their own. Where
    // both are the same, it is measured; otherwise, it is known within bounds.
    struct Reading {
        double lowest, highest;
        double below, above;  // standard deviations, > 0
        double age_s = 0;     // of what is known

        // By how many of these a shape is off that reads so much there, and its change with that.
        double off(double read) const noexcept {
            return read > highest ? (highest - read) / above : read < lowest ? (lowest - read) / below : 0;
        }
        double off_slope(double read) const noexcept {
            return read > highest ? 1 / above : read < lowest ? 1 / below : 0;
        }
    };
    using Values = PressureShape::Values;
    struct Solution {
        Values values{};
        // The Cholesky factor L of their covariance, L Lᵀ, by rows.
        std::array<Values, PressureShape::parameters> deviation{};
    };

    // At least one field. `usual_mm`: the prior's size of a contact.
    PressureFit(std::vector<SkinField> fields, double usual_mm);

    // For one or several readings of each field, those of all fields one after the other, the `lowest` of one
    // of which is > 0. Unless it moves, the velocity is 0. The same for the same readings: it starts from
    // their moments, and remembers nothing.
    Solution operator()(std::span<const Reading> readings, bool moves = false) const noexcept;
    // The sum of the squares of what the readings are off.
    double misfit(std::span<const Reading> readings, const PressureShape& shape) const noexcept;

    PressureShape shape(const Values& values) const noexcept { return {values, mean_variance_mm2_}; }
    std::span<const SkinField> fields() const noexcept { return fields_; }
    // Calls f(shape, other) for each pair of shapes that lie one standard deviation off the solution, one on
    // each side, in as many independent ways as it has parameters at present: half the differences of what
    // depends on the shape are its standard deviations, whose squares add up. How the velocity varies by
    // itself is left out.
    template <class F>
    void each_deviation(const Solution& solution, const F& f) const noexcept {
        for (std::size_t k = 0; k < PressureShape::at_present; ++k) {
            Values above = solution.values;
            Values below = solution.values;
            for (std::size_t i = 0; i < PressureShape::parameters; ++i) {
                above[i] += solution.deviation[i][k];
                below[i] -= solution.deviation[i][k];
            }
            f(shape(above), shape(below));
        }
    }

    std::size_t heap_bytes() const noexcept;

  private:
    struct Prior {
        Values mean, weight;  // 1/variance
    };
    const SkinField& field_of(std::size_t reading) const noexcept {
        return fields_[reading % fields_.size()];
    }
    Values start(std::span<const Reading> readings, bool moves) const noexcept;
    double cost(std::span<const Reading> readings, const Prior& prior, const Values& values) const noexcept;
    // The gradient of half the cost, downwards, and the lower half of its curvature.
    struct Slope {
        Values gradient{};
        std::array<Values, PressureShape::parameters> curvature{};
    };
    Slope slope(std::span<const Reading> readings, const Prior& prior, const Values& values) const noexcept;

    std::vector<SkinField> fields_;
    double mean_variance_mm2_;
    double usual_log_mm2_;
    Values weight_{};  // of the prior
};

}  // namespace afferent
