// The concept of an output: what an estimate drives.
#pragma once

#include <concepts>

#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/effort.hpp"
#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

struct GripCommand {
    double gain = 0;     // the factor on the closing effort that led to the command, 0 to 1
    double command = 0;  // to the motor, -1 (open) to 1 (close)

    friend bool operator==(const GripCommand&, const GripCommand&) = default;
};

// What the hand does in GripState::safe.
enum class SafeState {
    hold,  // closes no further; the user may open
    open,  // opens by itself
};

// An output is built from its parameters, which are checked: O(parameters) throws ParameterError. It is
// called once for each step of the controller, at times that do not decrease:
//
//   output(now, estimate, state, effort)   The command for the time until the next step.
//
// The laws that every output keeps, whatever it is given, NaN and infinity included:
//   - gain and command are within their ranges;
//   - unless the state is `operating` the gain is 0 and the command does not close the hand (<= 0);
//   - a force or an effort that is NaN never closes it;
//   - the answer depends on the parameters and these four arguments only, so a snapshot has nothing to hold.
template <class O>
concept Output = std::constructible_from<O, const typename O::Parameters&> &&
    std::copyable<typename O::Parameters> &&
    requires(O output, TimePoint now, const Estimate& estimate, GripState state, const Effort& effort) {
    { output(now, estimate, state, effort) } -> std::same_as<GripCommand>;
};

}  // namespace afferent
