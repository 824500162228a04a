// A force by particles: each has a history of motions, and given that, what is linear is a Gaussian.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "afferent/decoders/estimate.hpp"
#include "afferent/decoders/force_belief.hpp"
#include "afferent/decoders/truncated_normal.hpp"

namespace afferent {

// The model of ForceBelief without its approximation, which merges the histories of its motions at every step
// (Rao–Blackwellised: Doucet, de Freitas, Murphy and Russell 2000). The state of a particle is the force, its
// rate of change, and as many further variables as are asked for. Repeatable: the same seed, the same
// estimates.
class MotionParticles {
  public:
    static constexpr int rest = ForceBelief::motions;
    static constexpr std::size_t force = 0;
    static constexpr std::size_t speed = 1;

    struct Options {
        ForceBelief::Parameters model = {};
        std::size_t particles = 300;
        std::size_t variables = 0;  // beside force and speed
        std::uint64_t seed = 1;
    };
    MotionParticles(double largest_n, const Options& options);
    MotionParticles(const MotionParticles&) = delete;
    MotionParticles& operator=(const MotionParticles&) = delete;

    // Time passes: motions change, forces flow. The further variables stay.
    void predict(double dt_s);
    // A further variable x becomes  a x + b F + c,  with noise of that variance.
    void drive(std::size_t variable, double a, double b, double c, double variance);
    // A variable was measured.
    void measure(std::size_t variable, double value, double variance);
    // It lies between two values: by moment matching in each particle.
    void truncate(std::size_t variable, double low, double high);
    // It is known, whatever was before.
    void set(std::size_t variable, double value);
    // It has come down to 0 some time within a span of time, at the speed a + b F > 0. What comes down faster
    // does so more often. Two variables that are tied to each other tell the same, and no more than one.
    void cross_zero(std::size_t variable, double a, double b, double span);
    // After each time that something was learnt: where few particles have nearly all of the weight, the
    // particles are resampled.
    void resample();

    // The force after further time, in which no motion changes.
    Estimate at(double dt_s) const;

  private:
    struct Particle {
        int motion;  // of ForceBelief, or rest
        double log_weight;
        double weight;
        double* mean;
        double* covariance;  // row by row
    };
    void change_motion(Particle& x, double dt_s);
    void flow(Particle& x, double dt_s) const;
    void meet_zero(Particle& x);
    void cut(Particle& x, std::size_t variable, const TruncatedNormal& to, double sigma);
    void start(Particle& x, int motion) const;
    void measure(Particle& x, std::size_t variable, double value, double variance);
    void point();
    double& covariance(Particle& x, std::size_t i, std::size_t j) const {
        return x.covariance[i * variables_ + j];
    }

    ForceBelief::Parameters parameters_;
    std::size_t variables_;
    std::vector<Particle> particles_;
    std::vector<double> states_;  // mean and covariance of each
    std::vector<double> column_;
    std::mt19937_64 random_;
};

}  // namespace afferent
