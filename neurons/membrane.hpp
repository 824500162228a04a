// The membrane and its threshold, which the leaky integrate-and-fire neurons share.
#pragma once

#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The neurons store the gap to threshold, z = v_th − v, instead of v. With time in units of tau_m,
//
//     dz/ds = −(1 + g) z + g W − c,      W = v_th − E_k,      c = R·I − (v_th − v_r),
//
// no contribution to z is a difference of large numbers. So near threshold, and for drives near the rheobase,
// z and c keep all their digits where v and R·I would have lost them.
class Membrane {
  public:
    // The parameters have been checked.
    explicit Membrane(const LifParameters& parameters) noexcept
        : Membrane(Interval(Milliseconds(parameters.tau_m_ms)).count(), parameters.v_r_mv,
                   parameters.v_th_mv) {}

    Membrane with_threshold(double v_th_mv) const noexcept { return {tau_ns_, v_r_mv_, v_th_mv}; }

    double units(Interval dt) const noexcept { return dt.count() / tau_ns_; }
    Interval interval(double units) const noexcept { return Interval(units * tau_ns_); }

    double v_mv(double gap_mv) const noexcept { return v_th_mv_ - gap_mv; }
    double reset_gap_mv() const noexcept { return reset_gap_mv_; }

    // c, the drive above the rheobase, to full relative precision: where the two are close their difference
    // is exact, and the rounding error of the rheobase itself is added.
    double excess_mv(double drive_mv) const noexcept { return (drive_mv - reset_gap_mv_) - lost_mv_; }

  private:
    Membrane(double tau_ns, double v_r_mv, double v_th_mv) noexcept
        : tau_ns_(tau_ns),
          v_r_mv_(v_r_mv),
          v_th_mv_(v_th_mv),
          reset_gap_mv_(v_th_mv - v_r_mv),
          lost_mv_(rounding_error(v_th_mv, v_r_mv, reset_gap_mv_)) {}

    // Exactly a − b − difference, where difference is a − b rounded.
    static double rounding_error(double a, double b, double difference) noexcept {
        const double b_seen = a - difference;
        const double a_seen = difference + b_seen;
        return (a - a_seen) - (b - b_seen);
    }

    double tau_ns_;
    double v_r_mv_;
    double v_th_mv_;
    double reset_gap_mv_;
    double lost_mv_;
};

}  // namespace afferent
