#include "afferent/decoders/exponential.hpp"

namespace afferent {

Exponential::Exponential(const Parameters& parameters, const DecodedAfferents& afferents)
    : estimator_(GripEstimator::of(afferents, parameters.curve, parameters.pooling)),
      rate_(afferents.read(), parameters.time_constant, parameters.pooling == Pooling::per_neuron) {}

void Exponential::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    rate_.resume(start, heard_until);
    estimator_.resume(last);
}

void Exponential::resume(const Snapshot& snapshot) {
    rate_.resume(snapshot.rate);
    estimator_.resume(snapshot.last);
}

std::size_t Exponential::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + estimator_.heap_bytes();
}

}  // namespace afferent
