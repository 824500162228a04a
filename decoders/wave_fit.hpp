// The plane wave in which the afferents of a patch fire while a periodic surface slides over it.
#pragma once

#include <cstddef>
#include <vector>

#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/readout.hpp"
#include "afferent/decoders/small_matrix.hpp"
#include "afferent/decoders/spike_trains.hpp"

namespace afferent {

// A surface of the period 2π/|k| that slides at the speed ω/|k| in the direction of k modulates each
// afferent's rate by the phase ωt − k·x at its place x. How strongly, and after which delay, depends on the
// afferent, and is not needed.
//
// Search. With c_i(ω) = Σ w(t) exp(iωt) over the spikes of afferent i, tapered by Hann's window w, the
// frequencies are the highest maxima of Σ |c_i(ω)|², and at each of them the wave vector is the maximum of
//
//     z(ω, k) = |Σ c_i(ω) exp(−ik·x_i)|² / Σ |c_i(ω)|².
//
// If the phases of afferents are independent, z exceeds a bound with the probability exp(−bound): the bound
// is such that the maximum over all that is searched exceeds it once in 1/false_alarm windows. A wave may
// have been found by a harmonic: where z is high for a half or a third of ω and k as well, that is the wave.
//
// Fit. The sum of cos(ωt − k·x − φ) over all spikes is maximised by Newton's method, and the covariance of ω
// and k is the sandwich for clustered data, in which each afferent counts by what it is itself off.
//
// Pressure. A field of the variance s² reads a wave where the pressure p is, s² ∇ ln p away from its middle:
// towards the middle of the contact, as if all places were closer together. Weighed by a pressure that falls
// to 0 at its rim, the shift is −s² V⁻¹ x in the mean, whatever its form is, by partial integration; V is the
// covariance of the contact. Under a flat punch it is 0. Counted by spikes, which follow the pressure in
// part, it is taken for fall_off ± fall_off_sigma of that, and k is corrected.
//
// Costs some milliseconds for a hundred afferents. Allocates nothing after construction.
class WaveFit {
  public:
    // Probability that independent trains are taken for a wave.
    static constexpr double false_alarm = 1e-3;
    static constexpr double highest_hz = 250;
    // Slower oscillations are not told: in periods a window.
    static constexpr double fewest_periods = 2;
    // A field of the standard deviation s feels exp(−4.5), a hundredth, of a wave of this wave number · s.
    static constexpr double widest_field = 3;

    static constexpr double fall_off = 0.5, fall_off_sigma = 0.2;

    // Throws ParameterError unless there are two fields at different places and the window is 20 ms to 4 s.
    WaveFit(const std::vector<SkinField>& fields, Duration window);

    // Fills in what belongs to the wave. Trains are of the same afferents and window.
    void operator()(const SpikeTrains& trains, TextureEstimate& estimate) noexcept;

    std::size_t heap_bytes() const noexcept;

  private:
    struct Wave {
        double radians_per_s = 0, x_per_mm = 0, y_per_mm = 0;
    };
    struct Found {
        Wave wave;
        double z = 0;
    };
    struct Complex {
        double re = 0, im = 0;
    };
    // ω, the components of k, and φ.
    static constexpr std::size_t unknowns = 4;
    struct Sums {
        double cosines = 0;
        SmallVector<unknowns> gradient{};
        SmallMatrix<unknowns> hessian{};
        SmallMatrix<unknowns> scores{};  // outer products of the afferents' gradients
        std::size_t afferents = 0;       // that have fired
    };

    void add_lags(const SpikeTrains& trains) noexcept;
    double power(std::size_t frequency) const noexcept;
    void find_frequencies() noexcept;
    void taper(const SpikeTrains& trains, double radians_per_s) noexcept;
    double coherence(double x_per_mm, double y_per_mm) const noexcept;
    Found best_at(double radians_per_s) noexcept;
    Found fundamental_of(const SpikeTrains& trains, Found found) noexcept;
    Sums sums(const SpikeTrains& trains, const Wave& wave, double phase) noexcept;
    bool refine(const SpikeTrains& trains, Wave& wave, SmallMatrix<unknowns>& covariance) noexcept;
    void correct_for_pressure(const SpikeTrains& trains, Wave& wave,
                              SmallMatrix<unknowns>& covariance) const noexcept;

    static constexpr std::size_t most_frequencies = 5;

    std::vector<SkinField> fields_;
    double window_s_;
    double step_x_per_mm_, step_y_per_mm_, most_per_mm_, least_per_mm_;
    double bound_;
    std::vector<double> cosines_;  // of all products of a frequency and a lag
    std::vector<double> lags_;     // tapered pairs of an afferent's spikes, by the time between them
    std::vector<double> powers_;   // by frequency, in steps of a quarter of 1/window
    std::vector<std::size_t> frequencies_;
    std::vector<Complex> tapered_, turned_, turn_;  // of each afferent
};

}  // namespace afferent
