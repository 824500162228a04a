// The plane wave in which the afferents of a patch fire while a periodic surface slides over it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/readout.hpp"
#include "afferent/decoders/small_matrix.hpp"
#include "afferent/decoders/spike_trains.hpp"
#include "afferent/decoders/work_budget.hpp"

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
// A fit costs about a millisecond for a hundred afferents. It may be spread over many calls, and its result
// does not depend on how it is spread. Allocates nothing after construction.
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

    // The next call of advance() begins a fit.
    void begin() noexcept;
    // Does as much of the fit as the budget allows. Returns true when the fit is complete and what belongs to
    // the wave has been filled in. All calls after begin() take the same trains, of the afferents and the
    // window that the constructor was given, and the same estimate.
    bool advance(const SpikeTrains& trains, WorkBudget& budget, TextureEstimate& estimate) noexcept;

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

    // What the next piece of work belongs to.
    enum class Stage : std::uint8_t { lags, powers, taper, row, column, part, sums, complete };
    struct State {
        Stage stage = Stage::lags;
        std::size_t next = 0;       // afferent or frequency of the stage
        std::size_t spike = 0;      // of that afferent
        std::size_t candidate = 0;  // frequencies that have been tried, with the present one
        Wave tried;                 // of which `tapered_` is taken
        double squares = 0;         // Σ |c_i(ω)|² of `tapered_`
        int row = 0, column = 0;    // of the wave vectors
        Found best;
        int part = 1;  // by which the best wave is divided: > 1 once all frequencies have been tried
        Found lower;
        Wave refined;
        double phase = 0;
        int steps = 0;  // of Newton's method, after one for the phase alone
        bool converged = false;
        Sums sums;
    };

    int rows() const noexcept { return static_cast<int>(most_per_mm_ / step_y_per_mm_); }
    double* weights_of(std::size_t afferent) noexcept {
        return &weights_[afferent * (weights_.size() / fields_.size())];
    }
    std::size_t next_piece(const SpikeTrains& trains) const noexcept;
    void do_next(const SpikeTrains& trains, TextureEstimate& estimate) noexcept;
    void go_to(Stage stage) noexcept;
    void add_lags(const SpikeTrains& trains) noexcept;
    void find_powers() noexcept;
    void find_frequencies() noexcept;
    void taper(const SpikeTrains& trains) noexcept;
    void try_next_frequency() noexcept;
    void begin_row() noexcept;
    void try_column() noexcept;
    void try_next_part() noexcept;
    void judge_part() noexcept;
    double coherence(double x_per_mm, double y_per_mm) const noexcept;
    void add_sums(const SpikeTrains& trains) noexcept;
    void refine(const SpikeTrains& trains, TextureEstimate& estimate) noexcept;
    static SmallMatrix<unknowns> covariance_of(Sums& at) noexcept;
    void correct_for_pressure(const SpikeTrains& trains, Wave& wave,
                              SmallMatrix<unknowns>& covariance) const noexcept;
    void tell(const Wave& wave, const SmallMatrix<unknowns>& covariance,
              TextureEstimate& estimate) const noexcept;

    static constexpr std::size_t most_frequencies = 5;

    std::vector<SkinField> fields_;
    double window_s_;
    double step_x_per_mm_, step_y_per_mm_, most_per_mm_, least_per_mm_;
    double bound_;
    std::vector<double> cosines_;  // of all products of a frequency and a lag
    std::vector<double> weights_;  // Hann's, of each spike of the window
    std::vector<double> lags_;     // tapered pairs of an afferent's spikes, by the time between them
    std::vector<double> powers_;   // by frequency, in steps of a quarter of 1/window
    std::vector<std::size_t> frequencies_;
    std::vector<Complex> tapered_, turned_;  // of each afferent
    // exp(i k_x x) of each afferent, for each column's k_x >= 0; exp(i k_y y), for each row's k_y >= 0.
    std::vector<Complex> column_turns_, row_turns_;
    State state_;
};

}  // namespace afferent
