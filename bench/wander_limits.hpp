// How exactly a force can be known that wanders (a Wiener process of `n2_per_s`), by what is sent of it.
#pragma once

#include <cmath>
#include <numbers>

namespace afferent {

// Mean squared errors in N², after Guo and Kostina 2019 (Optimal causal rate-constrained sampling for a class
// of continuous Markov processes) and Gorbunov and Pinsker 1974, at R bit/s or f samples or events a second.
// They are limits of a force that wanders. A hand's force is smoother than that, so that what predicts it may
// fall below them.
struct WanderLimits {
    double n2_per_s;

    // By the times of events, which cost nothing: only their direction is sent.
    double event_triggered(double bits_per_s) const { return n2_per_s / (6 * bits_per_s); }
    // By samples at equal intervals.
    double uniform(double bits_per_s) const { return 5 * n2_per_s / (6 * bits_per_s); }
    // By any causal code that tells by its bits alone, and not by when they come.
    double causal(double bits_per_s) const { return n2_per_s / (2 * std::numbers::ln2 * bits_per_s); }
    // The average of an integrate-and-fire neuron's intervals.
    double integrate_and_fire(double events_per_s) const { return 0.79 * n2_per_s / events_per_s; }
    double periodic_samples(double samples_per_s) const { return 0.5 * n2_per_s / samples_per_s; }
    double send_on_delta(double events_per_s) const { return n2_per_s / (6 * events_per_s); }

    // The error that the change of the force adds while a packet fills, for half of its span in the mean, and
    // travels.
    double aged(double mean_square, double span_s, double delivery_s) const {
        return mean_square + n2_per_s * (span_s / 2 + delivery_s);
    }
};

}  // namespace afferent
