// Which of an adapting neuron's rates is meant.
#pragma once

namespace afferent {

enum class RateKind {
    steady,  // after adaptation, under a drive held for good
    onset,   // the reciprocal of the first interspike interval after a step from rest
};

}  // namespace afferent
