#include "afferent/decoders/emg_gain.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// What a doubtful estimate takes at least: what raises sigma, such as a slow afferent, covers the force by
// two.
constexpr double doubtful_sigmas = 2;

}  // namespace

EmgGain::EmgGain(const Parameters& parameters) : parameters_(parameters) {
    require(parameters.onset_n >= 0, "onset_n", ">= 0", parameters.onset_n);
    require(parameters.lambda_n > 0, "lambda_n", "> 0", parameters.lambda_n);
    require(parameters.limit_n > parameters.onset_n, "limit_n", "> onset_n", parameters.limit_n);
    require(parameters.upper_bound_sigmas >= 0, "upper_bound_sigmas", ">= 0", parameters.upper_bound_sigmas);
    require(parameters.saturated >= 0 && parameters.saturated <= 1, "saturated", "0 to 1",
            parameters.saturated);
    at_limit_ = parameters.shape == Shape::continuous
                    ? std::exp(-(parameters.limit_n - parameters.onset_n) / parameters.lambda_n)
                    : 0;
}

double EmgGain::operator()(double force_n) const noexcept {
    if (!(force_n < parameters_.limit_n)) return 0;
    if (force_n <= parameters_.onset_n) return 1;
    const double decay = std::exp(-(force_n - parameters_.onset_n) / parameters_.lambda_n);
    return (decay - at_limit_) / (1 - at_limit_);
}

double EmgGain::operator()(const Estimate& estimate) const noexcept {
    const Doubt doubt = parameters_.doubtful == Doubtful::by_upper_bound ? estimate.doubt : Doubt::none;
    if (doubt == Doubt::saturated) return std::min(parameters_.saturated, (*this)(estimate.force_n));
    const double sigmas =
        std::max(parameters_.upper_bound_sigmas, doubt == Doubt::none ? 0 : doubtful_sigmas);
    const double gain = at(estimate.force_n, estimate.sigma_n, sigmas);
    if (!estimate.coming) return gain;
    return std::min(gain, at(estimate.coming->force_n, estimate.coming->sigma_n, sigmas));
}

double EmgGain::at(double force_n, double sigma_n, double sigmas) const noexcept {
    if (sigmas == 0) return (*this)(force_n);
    if (!(sigma_n >= 0)) return 0;
    return (*this)(force_n + sigmas * sigma_n);
}

}  // namespace afferent
