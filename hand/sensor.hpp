// A textile piezoresistive element in a voltage divider, read by a converter. Included by whoever builds a
// scene.
#pragma once

#include <optional>

namespace afferent {

// Force → hysteresis → resistance → divider → noise → counts. Without a resistance curve, counts are
// proportional to force.
class Sensor {
  public:
    //     R(F) = minimum + (maximum − minimum) / (1 + F / half_force)
    struct ForceResistance {
        double maximum_ohm = 20'000;
        double minimum_ohm = 500;
        double half_force_n = 0.8;
        double divider_ohm = 4'700;
        bool operator==(const ForceResistance&) const = default;
    };
    struct Parameters {
        double full_scale_n = 10;
        unsigned adc_bits = 12;
        double noise_counts = 0;  // standard deviation
        double hysteresis = 0;    // loading reads low, unloading high, by this fraction of the force
        std::optional<ForceResistance> force_resistance = std::nullopt;
        bool operator==(const Parameters&) const = default;
    };
    struct State {
        double felt_n = 0;  // the force after the hysteresis
    };

    // Throws ParameterError unless full_scale_n > 0, adc_bits is 1 to 24, noise_counts >= 0, hysteresis is in
    // [0, 1), resistances are > 0 with maximum_ohm > minimum_ohm, and half_force_n > 0.
    explicit Sensor(const Parameters& parameters);

    // The reading of the converter, a whole number of counts in its range. `gaussian` is a standard normal
    // variate.
    double counts(State& state, double force_n, double gaussian) const noexcept;

    // The inverse of the curve, within [0, full scale]: the default calibration.
    double force_n(double counts) const noexcept;

    // The standard deviation of a reading at that force, by noise and by the converter's steps.
    double noise_n(double force_n) const noexcept;

    bool within_range(double force_n) const noexcept {
        return force_n >= 0 && force_n <= parameters_.full_scale_n;
    }
    double highest_count() const noexcept { return highest_count_; }

  private:
    double fraction(double force_n) const noexcept;  // of the converter's range

    Parameters parameters_;
    double highest_count_;
};

}  // namespace afferent
