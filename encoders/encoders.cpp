#include "afferent/encoders/sustained.hpp"
#include "afferent/encoders/transient.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

Sustained::Sustained(const Parameters& parameters)
    : gain_(parameters.gain_mv_per_n), bias_(parameters.bias_mv) {
    require(gain_ > 0, "gain_mv_per_n", "> 0", gain_);
    require(true, "bias_mv", "finite", bias_);
}

Transient::Transient(const Parameters& parameters)
    : gain_(parameters.gain_mv_s_per_n), bias_(parameters.bias_mv) {
    require(gain_ > 0, "gain_mv_s_per_n", "> 0", gain_);
    require(true, "bias_mv", "finite", bias_);
}

}  // namespace afferent
