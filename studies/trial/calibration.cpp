#include "afferent/studies/trial/calibration.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/numbers.hpp"
#include "afferent/studies/trial/published.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {
namespace {

class Calibrator {
  public:
    Calibrator(std::uint32_t presentations, const CalibrationProgress& progress)
        : presentations_(presentations), progress_(progress) {}

    std::optional<Proportion> broken(const Scene& scene, std::string_view condition, std::uint32_t of) const {
        const Experiment experiment(scene, condition);
        bool goes_on = true;
        std::uint32_t told = 0;
        const auto presented = experiment.present(0, of, [&](std::uint32_t done) {
            goes_on = progress_(condition, done - told);
            told = done;
            return goes_on;
        });
        if (!goes_on || presented.size() < of) return std::nullopt;
        return tally(presented).delicate.broken();
    }

    std::optional<CalibratedNumber> find(const Scene& scene, std::string_view path,
                                         std::string_view condition) const {
        const TrialNumber& number = *find_trial_number(path);
        const auto found = find_crossing({.low = number.low,
                                          .high = number.high,
                                          .target = published(condition)->broken.value(),
                                          .presentations = presentations_,
                                          .tolerance = tolerance},
                                         [&](double value, std::uint32_t of) {
                                             return broken(with_number(scene, number, value), condition, of);
                                         });
        if (!found) return std::nullopt;
        return CalibratedNumber{path, condition, *found};
    }

    // Both, one after the other. The aim hardly moves the figure with force, so that a second pass is rarely
    // needed.
    std::optional<TrialCalibration> find_both(const Scene& scene) const {
        constexpr int most_passes = 4;
        Scene delicate = scene;
        if (delicate.trial) delicate.trial->slippery.part = 0;
        for (int pass = 1;; ++pass) {
            auto stiffness = find(delicate, "trial.object.stiffness_n_per_mm", "force");
            if (!stiffness) return std::nullopt;
            delicate = calibrated(delicate, *stiffness);
            const auto aim = find(delicate, "trial.user.aim_n", "none");
            if (!aim) return std::nullopt;
            delicate = calibrated(delicate, *aim);
            const auto again = broken(delicate, stiffness->condition, presentations_);
            if (!again) return std::nullopt;
            stiffness->found.counted = *again;
            const double off = std::abs(again->value() - published(stiffness->condition)->broken.value());
            if (off <= std::max(tolerance, 1.0 / presentations_) || pass == most_passes ||
                !stiffness->found.is_reached)
                return TrialCalibration{*stiffness, *aim, calibrated(calibrated(scene, *stiffness), *aim)};
        }
    }

  private:
    static constexpr double tolerance = 0.001;

    static Scene calibrated(const Scene& scene, const CalibratedNumber& number) {
        constexpr double digits = 1000;
        return with_number(scene, *find_trial_number(number.path),
                           std::round(digits * number.found.parameter) / digits);
    }

    std::uint32_t presentations_;
    const CalibrationProgress& progress_;
};

}  // namespace

std::optional<TrialCalibration> calibrate_trial(const Scene& scene, std::uint32_t presentations,
                                                const CalibrationProgress& progress) {
    return Calibrator(presentations, progress).find_both(scene);
}

}  // namespace afferent
