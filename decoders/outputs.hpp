// The closed list of outputs, and the output that a scene has chosen from it.
#pragma once

#include <variant>

#include "afferent/decoders/emg_gain_output.hpp"
#include "afferent/decoders/output.hpp"

namespace afferent {

template <Output... O>
struct OutputList {
    using Any = std::variant<O...>;
    using Parameters = std::variant<typename O::Parameters...>;
};

// To add an output, add its header above and its name here; the laws that every output keeps are then tested
// for it.
using Outputs = OutputList<EmgGainOutput>;

using OutputParameters = Outputs::Parameters;

// Any of the outputs behind the same interface: an Output itself (output.hpp).
class GripOutput {
  public:
    using Parameters = OutputParameters;

    // The output whose parameters these are. Throws ParameterError, as that one does.
    explicit GripOutput(const Parameters& parameters);

    GripCommand operator()(TimePoint now, const Estimate& estimate, GripState state, const Effort& effort);

  private:
    Outputs::Any output_;
};

static_assert(Output<GripOutput>);

inline GripOutput make_output(const OutputParameters& parameters) { return GripOutput(parameters); }

}  // namespace afferent
