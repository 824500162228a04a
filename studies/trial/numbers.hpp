// The numbers of a trial that a reader may doubt: where each comes from, and how far it may plausibly be off.
#pragma once

#include <span>
#include <string_view>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct TrialNumber {
    std::string_view path;  // in the scene, with its unit
    // Plausible: what a reader might put in its place.
    double low;
    double high;
    std::string_view source;  // or "assumed"
    // The number in a scene that has a trial. Makes what has to be there for it.
    double& (*in)(Scene& scene);
};

// Those of user, electrode, hand, object, radio, link and gain. The first two are calibrated. A scene without
// the number gets it where it is asked for.
std::span<const TrialNumber> trial_numbers() noexcept;

// The number of that path; null if there is none.
const TrialNumber* find_trial_number(std::string_view path) noexcept;

// A scene with another value for one number; one of the gain, in the conditions' own gains as well.
Scene with_number(const Scene& scene, const TrialNumber& number, double value);
double value_in(const Scene& scene, const TrialNumber& number);

}  // namespace afferent
