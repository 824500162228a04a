// The drive of a neuron from one of its interspike intervals, exactly.
#pragma once

#include <memory>

#include "afferent/decoders/interval_table.hpp"
#include "afferent/neurons/models.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The neuron that a model is, or approximates.
const LifParameters& lif_of(const NeuronModel& model) noexcept;

// g depends on spike times only, so it is known from the spikes, and between two spikes the gap to threshold
// is linear in the drive (neurons/propagator.hpp). The gap falls from the reset to 0:
//
//     0 = z_reset Φ − c Ψ + W X,      c = (z_reset Φ + W X)/Ψ
//
// c is the drive above the rheobase: the mean over the interval with the weights of Ψ, which lie on its last
// tau_m. It takes no fit, and adaptation adds no bias.
//
// A neuron on a chip is taken for the one that it approximates.
class IntervalDrive {
  public:
    explicit IntervalDrive(const NeuronModel& model);

    struct Solution {
        double excess_mv;  // c; infinite within the refractory period
        double per_s_mv;   // how fast c falls as the interval gets longer
        double lag_s;      // how long before the interval's end the mean lies
        double kept;       // the part of g that is left at its end
    };
    // For a spike after which g was `g`, and the next one after `interval`. If the next one has not come by
    // then, c is an upper bound.
    Solution solve(double g, Duration interval) const noexcept;

    // The excess c at which a resting neuron needs five tau_m to fire; less cannot be told from silence.
    double least_excess_mv() const noexcept;

    double decayed(double g, Duration time) const noexcept;
    // g just after a spike, from g just before it.
    double after_spike(double g) const noexcept { return g + lif_.delta_g; }
    // g after a time with spikes at a rate, from g at its beginning.
    double driven(double g, Duration time, double rate_hz) const noexcept;

    // The change of c with g at the interval's end.
    double excess_per_g_mv() const noexcept { return lif_.v_th_mv - lif_.e_k_mv; }
    double tau_m_s() const noexcept { return lif_.tau_m_ms * 1e-3; }
    double tau_g_s() const noexcept { return lif_.tau_g_ms * 1e-3; }
    // Shared by all neurons of its ratio.
    const IntervalTable& table() const noexcept { return *table_; }

  private:
    LifParameters lif_;
    std::shared_ptr<const IntervalTable> table_;
};

}  // namespace afferent
