#include "afferent/decoders/sliding_window.hpp"

namespace afferent {

SlidingWindow::SlidingWindow(const Parameters& parameters, const DecodedAfferents& afferents)
    : estimator_(GripEstimator::of(afferents, parameters.curve, parameters.pooling)),
      rate_(afferents.read(), parameters.window) {}

Estimate SlidingWindow::estimate(TimePoint now) noexcept {
    rate_.advance(now);
    return estimator_(rate_);
}

void SlidingWindow::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) {
    rate_.resume(start, heard_until);
    estimator_.resume(last);
}

void SlidingWindow::resume(const Snapshot& snapshot) {
    rate_.resume(snapshot.rate);
    estimator_.resume(snapshot.last);
}

std::size_t SlidingWindow::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + estimator_.heap_bytes();
}

}  // namespace afferent
