// The sensors of one patch: from the force on its elements to what the coprocessor is given.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "afferent/scene/patch_plan.hpp"

namespace afferent {

// A dead element reads 0, a stuck one always the same. A force below 0 or above full scale is clipped, and
// counted.
class PatchSensors {
  public:
    // The plan outlives it.
    PatchSensors(const PatchPlan& patch, std::uint64_t seed);

    // Each of the elements that the plan has sampled feels its share of a grip force: through sensor,
    // converter and calibration.
    std::span<const double> feel(double grip_force_n);
    // To be called before each feel() of a simulated sensor: the grip force whose sample arrives at this
    // scan, of sensor.delay_ms ago rounded up to whole scans, where the force is `grip_force_n` now. 0 before
    // the first sample has arrived.
    double arriving_n(double grip_force_n) noexcept;
    // The elements first, first + 1, ... feel these forces at the index-th sample of their patch; returns
    // what they tell.
    std::span<const double> feel_elements(std::uint32_t first, std::span<const double> forces_n,
                                          std::uint64_t index);
    // Samples taken elsewhere: in newtons, or in counts, which are calibrated.
    std::span<const double> take_newtons(std::span<const double> forces_n);
    std::span<const double> take_counts(std::span<const double> counts);

    // The force of so many counts of an element that works: clipped to its range, and calibrated.
    double force_n(double counts) const noexcept;

    // Counts the samples of the plan's `counted` elements only; so do the three functions below.
    std::uint64_t samples() const noexcept { return samples_ * patch_.counted.size() + single_samples_; }
    std::uint64_t clipped() const noexcept { return clipped_; }
    std::uint64_t negative() const noexcept { return negative_; }
    std::uint64_t positive() const noexcept { return positive_; }

  private:
    double calibrated(double counts) const noexcept;
    // `noise(element)` is a standard normal number.
    template <class Noise>
    void feel(double grip_force_n, const Noise& noise);
    void count(std::uint32_t element, double value, bool within_range) noexcept {
        if (!patch_.counted.contains(element)) return;
        if (!within_range) ++clipped_;
        if (value < 0) ++negative_;
        if (value > 0) ++positive_;
    }
    void apply_faults() noexcept;
    std::span<const double> with_faults();

    const PatchPlan& patch_;
    std::uint64_t seed_;
    Sensor sensor_;
    std::vector<Sensor::State> states_;
    std::vector<double> under_way_n_;  // grip forces whose samples have not arrived, in a ring
    std::vector<double> forces_n_;
    std::uint64_t samples_ = 0;         // of all elements
    std::uint64_t single_samples_ = 0;  // of some elements, each counted
    std::uint64_t clipped_ = 0;
    std::uint64_t negative_ = 0;  // samples below 0, and
    std::uint64_t positive_ = 0;  // above it, before they were clipped
};

}  // namespace afferent
