// The true spikes of a workload, to 50 digits.
#pragma once

#include "bench/workload.hpp"

namespace afferent::bench {

// The spikes of one neuron. Slow: tenths of a millisecond for a row, milliseconds for a spike of a stiff
// neuron.
Train true_train(const Workload& workload, std::size_t neuron);

// The spikes under a drive held from the beginning. They are computed until the interval between them no
// longer changes in 25 digits; from then on every spike is known. Throws std::runtime_error if it does not
// settle.
class SettledTrain {
  public:
    SettledTrain(const LifParameters& parameters, double drive_mv);

    // The n-th spike, from 0 on.
    SpikeTime spike(std::size_t n) const;

  private:
    Train beginning_;
    // The interval in whole nanoseconds and the rest, so that n times it is exact for large n.
    std::int64_t interval_ns_ = 0;
    long double interval_rest_ns_ = 0;
};

}  // namespace afferent::bench
