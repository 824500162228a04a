// The sensor of a patch. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "afferent/encoders/calibration.hpp"
#include "afferent/hand/sensor.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

void each_field(Is<Sensor::ForceResistance> auto& curve, auto&& f) {
    f(above("maximum_ohm", 0, 1e12), curve.maximum_ohm);
    f(above("minimum_ohm", 0, 1e12), curve.minimum_ohm);
    f(within("half_force_n", 1e-6, 1e6), curve.half_force_n);
    f(above("divider_ohm", 0, 1e12), curve.divider_ohm);
}

void each_field(Is<Calibration::Point> auto& point, auto&& f) {
    f(within("counts", -1e9, 1e9), point.counts);
    f(within("force_n", -1e6, 1e6), point.force_n);
}

namespace scene {

enum class OutOfRange { clip, refuse };

struct StuckElement {
    std::uint32_t element = 0;
    double force_n = 0;
    bool operator==(const StuckElement&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("element", 0, most_addresses - 1), self.element);
        f(within("force_n", 0, 1e6), self.force_n);
    }
};

struct Sensor : afferent::Sensor::Parameters {
    double rate_hz = 200;
    std::vector<Calibration::Point> calibration = {};
    std::vector<std::uint32_t> dead_element = {};
    std::vector<StuckElement> stuck_element = {};
    double delay_ms = 0;     // from the force to the arrival of its sample
    double reference_v = 5;  // at the highest count; for tables in volts
    OutOfRange out_of_range = OutOfRange::clip;
    bool operator==(const Sensor&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("rate_hz", 0.001, 1e6), self.rate_hz);
        f(within("full_scale_n", 1e-6, 1e6), self.full_scale_n);
        f(within("adc_bits", 1, 24), self.adc_bits);
        f(within("noise_counts", 0, 1e6), self.noise_counts);
        f("force_resistance", self.force_resistance);
        f(below("hysteresis", 0, 1), self.hysteresis);
        f(within("delay_ms", 0, 1000), self.delay_ms);
        f("calibration", self.calibration);
        f(within("dead_element", 0, most_addresses - 1), self.dead_element);
        f("stuck_element", self.stuck_element);
        f(within("reference_v", 1e-6, 1e6), self.reference_v);
        f("out_of_range", self.out_of_range);
    }
};

}  // namespace scene

// Throws ParameterError if the sensor is invalid for a patch of that many elements: a curve or calibration
// out of its rules, or a dead or stuck element that does not exist.
void check(const scene::Sensor& sensor, std::uint32_t elements);

}  // namespace afferent
