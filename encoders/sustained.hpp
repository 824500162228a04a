// The sustained channel: drive in proportion to force, as slowly adapting afferents respond.
#pragma once

#include "afferent/encoders/encoder.hpp"

namespace afferent {

//     drive = gain · force + bias
class Sustained {
  public:
    struct Parameters {
        double gain_mv_per_n;
        double bias_mv = 0;
    };
    struct State {};

    // Throws ParameterError: gain_mv_per_n > 0, both finite.
    explicit Sustained(const Parameters& parameters);

    double drive_mv(State&, TimePoint, double force_n) const noexcept { return gain_ * force_n + bias_; }

  private:
    double gain_;
    double bias_;
};

static_assert(Encoder<Sustained>);

}  // namespace afferent
