// Calibrates a trial: the two numbers that decide most and that the paper does not give, on two of its
// figures.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "afferent/scene/scene.hpp"
#include "afferent/studies/trial/crossing.hpp"

namespace afferent {

// What is calibrated, on the objects that break under a condition (trial/published.hpp), within the plausible
// range of trial/numbers.hpp.
struct CalibratedNumber {
    std::string_view path;
    std::string_view condition;
    Crossing found;
};

// With feedback, objects break that are so stiff that the force has passed their breaking force before the
// feedback arrives: how many, the median stiffness decides. Without, those break as well at which the user
// has aimed too high. The gain's lambda moves neither by more than a point, so that no figure of the paper
// tells it.
struct TrialCalibration {
    CalibratedNumber stiffness;  // trial.object.stiffness_n_per_mm, with force
    CalibratedNumber aim;        // trial.user.aim_n, without feedback, where the gain plays no part
    Scene scene;                 // with both, to three decimals
    bool is_reached() const noexcept { return stiffness.found.is_reached && aim.found.is_reached; }
};

// Called with the condition and the presentations of it that are done since the call before; false stops.
using CalibrationProgress = std::function<bool(std::string_view condition, std::uint32_t done)>;

// Every count presents delicate objects with the numbers 0 to presentations − 1. The heavy object is left
// out. None: it was stopped. Throws SceneError, as Experiment does.
std::optional<TrialCalibration> calibrate_trial(const Scene& scene, std::uint32_t presentations,
                                                const CalibrationProgress& progress);

}  // namespace afferent
