// The factor on the user's closing EMG: the harder the grip, the less the hand closes.
#pragma once

namespace afferent {

// After the paper, an exponential decay with force:
//
//     1                          F < onset
//     exp(−(F − onset)/lambda)   onset <= F < limit
//     0                          F >= limit
//
// The continuous shape subtracts the step at the limit and rescales, so that it falls from 1 to 0 without
// one.
class EmgGain {
  public:
    enum class Shape { exponential, continuous };
    struct Parameters {
        double onset_n = 2;
        double lambda_n = 3;
        double limit_n = 10;
        Shape shape = Shape::exponential;
        bool operator==(const Parameters&) const = default;
    };

    // Throws ParameterError: onset_n >= 0, lambda_n > 0, limit_n > onset_n, all finite.
    explicit EmgGain(const Parameters& parameters);

    // In [0, 1] for every force; 0 for NaN, because what is not known must not close the hand.
    double operator()(double force_n) const noexcept;

  private:
    Parameters parameters_;
    double at_limit_;  // what the continuous shape subtracts
};

}  // namespace afferent
