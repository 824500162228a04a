// The judge of the decoder `filter` is right where the right answer is known, and good where it is not.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "bench/force_score.hpp"
#include "bench/motion_particles.hpp"
#include "bench/spike_particles.hpp"

namespace afferent {
namespace {

using Vector = std::array<double, 3>;
using Matrix = std::array<Vector, 3>;

// A Kalman filter of force, speed and one membrane, in plain matrices.
struct Kalman {
    Vector x{};
    Matrix p{};

    void flow(const Matrix& a, const Vector& c, const Matrix& q) {
        const auto transform = [&](const Matrix& left, const Matrix& right, bool transposed) {
            Matrix product{};
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 3; ++j)
                    for (std::size_t k = 0; k < 3; ++k)
                        product[i][j] += left[i][k] * (transposed ? right[j][k] : right[k][j]);
            return product;
        };
        Vector moved = c;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k) moved[i] += a[i][k] * x[k];
        x = moved;
        p = transform(transform(a, p, false), a, true);
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) p[i][j] += q[i][j];
    }
    void measure(std::size_t what, double value, double variance) {
        const Vector column{p[0][what], p[1][what], p[2][what]};
        const double total = column[what] + variance;
        const double error = value - x[what];
        for (std::size_t i = 0; i < 3; ++i) {
            x[i] += column[i] / total * error;
            for (std::size_t j = 0; j < 3; ++j) p[i][j] -= column[i] * column[j] / total;
        }
    }
};

TEST(MotionParticles, AreAKalmanFilterWhereThereIsOneMotion) {
    constexpr double sigma = 4, tau_s = 0.2, drift = 0.01, dt_s = 0.005, largest_n = 50;
    ForceBelief::Parameters parameters{.releases = 0, .leaves_rest_per_s = 0};
    parameters.motion.fill({sigma, tau_s, drift, 0});
    MotionParticles particles(largest_n, {.model = parameters, .particles = 40, .variables = 1});

    Kalman kalman;
    kalman.p[0][0] = largest_n * largest_n / 4;
    kalman.p[1][1] = sigma * sigma;
    const double kept = std::exp(-dt_s / tau_s);
    const double reach_s = tau_s * (1 - kept);
    const Matrix flow{{{1, reach_s, 0}, {0, kept, 0}, {0, 0, 1}}};
    // The integral of an Ornstein–Uhlenbeck process, and the process.
    const double r = dt_s / tau_s;
    const double ff = sigma * sigma * tau_s * tau_s * (2 * r - 3 + 4 * kept - kept * kept) + drift * dt_s;
    const double fv = sigma * sigma * tau_s * (1 - kept) * (1 - kept);
    const Matrix noise{{{ff, fv, 0}, {fv, sigma * sigma * (1 - kept * kept), 0}, {0, 0, 0}}};
    constexpr double a = 0.6, b = -0.3, c = 2, membrane_noise = 0.01;
    const Matrix drive{{{1, 0, 0}, {0, 1, 0}, {b, 0, a}}};
    const Matrix drive_noise{{{0, 0, 0}, {0, 0, 0}, {0, 0, membrane_noise}}};

    for (int k = 0; k < 400; ++k) {
        const double force_n = 20 + 3 * std::sin(0.03 * k);
        // The first tells that the force is not at rest.
        if (k % 7 == 0) {
            particles.measure(MotionParticles::force, force_n, 0.02);
            kalman.measure(0, force_n, 0.02);
        }
        particles.drive(2, a, b, c, membrane_noise);
        kalman.flow(drive, {0, 0, c}, drive_noise);
        if (k % 11 == 3) {
            const double gap_mv = -10 + 2 * std::sin(0.1 * k);
            particles.measure(2, gap_mv, 0.05);
            kalman.measure(2, gap_mv, 0.05);
        }
        if (k % 50 == 49) {
            particles.set(2, 7);
            kalman.x[2] = 7;
            for (std::size_t i = 0; i < 3; ++i) kalman.p[2][i] = kalman.p[i][2] = 0;
        }
        particles.resample();
        const Estimate now = particles.at(0);
        ASSERT_NEAR(now.force_n, kalman.x[0], 1e-8) << k;
        ASSERT_NEAR(now.sigma_n, std::sqrt(kalman.p[0][0]), 1e-7) << k;
        EXPECT_NEAR(particles.at(dt_s).force_n, kalman.x[0] + reach_s * kalman.x[1], 1e-8) << k;
        particles.predict(dt_s);
        // `ff` cancels to some ten digits.
        kalman.flow(flow, {0, 0, 0}, noise);
    }
}

TEST(MotionParticles, WeighTheMotionsThatExplainWhatIsMeasured) {
    MotionParticles particles(50, {});
    // A hand that touches nothing, and then closes at 40 N/s: within 30 ms the force is followed.
    for (int k = 0; k < 300; ++k) {
        const double force_n = std::max(0.0, 0.2 * (k - 200));
        particles.measure(MotionParticles::force, force_n, 1e-4);
        particles.resample();
        const double error_n = particles.at(0).force_n - force_n;
        if (k > 20 && k < 200) {
            EXPECT_LT(particles.at(0).force_n, 0.01) << k;
        }
        if (k > 206) {
            EXPECT_NEAR(error_n, 0, 0.1) << k;
        }
        particles.predict(0.005);
    }
}

TEST(SpikeParticles, FollowAForceFromTheSpikesOfOneNeuron) {
    Scene scene;
    scene.patches = {{.name = "grip", .elements = 1}};
    scene.patches.front().sensor.full_scale_n = 25;
    const TouchedForce touched = touched_force(
        scene, 4s, [](TimePoint time) { return std::max(0.0, 8 * std::sin(2 * (seconds(time) - 0.5))); });
    FollowedForce followed{touched.true_n, touched.sensed_n, touched.sensed_n,
                           follow_by_particles(touched, 100us, 5ms, {})};
    const ForceScore found = score(std::span(&followed, 1), Touch::step);
    EXPECT_LT(found.rms_sensed_n, 0.3);
    EXPECT_GT(found.coverage_95.value(), 0.9);
}

}  // namespace
}  // namespace afferent
