// Solvers that step, as a competent user would write them: structure of arrays in tiles that stay in the
// cache, inner loops that the compiler vectorises for the processor at hand, the conductance decayed by its
// exact factor.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "bench/solver.hpp"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define AFFERENT_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define AFFERENT_CLONES
#endif

namespace afferent::bench {
namespace {

// How a crossing inside a step is treated.
enum class Crossing {
    at_end,        // spike and reset are at the end of the step
    interpolated,  // the spike is at the crossing, the reset at the end of the step
    corrected,     // both are at the crossing, and the rest of the step is computed again
};

constexpr std::size_t tile = 256;
constexpr int most_spikes_in_a_step = 1000;

// Time in units of tau_m.
template <class Real>
struct Tile {
    alignas(64) std::array<Real, tile> v, g, drive, next_v, next_g, v_th, delta_g;
    alignas(64) std::array<std::uint8_t, tile> crossed;
};

template <class Real>
struct Constants {
    Real v_r, e_k;
    Real step;
    Real decay, half_decay;  // of g in a step, and in half of one
    Real fall;               // 1 − step/a: of g in Euler's step
};

// One step of one neuron, or a part of one. A whole step uses exact factors for g.
struct Euler {
    template <class Real>
    [[gnu::always_inline]] static void step(const Constants<Real>& c, Real drive, Real& v, Real& g) {
        v += c.step * (c.v_r - v + drive - g * (v - c.e_k));
        g *= c.fall;
    }
};

struct ExponentialEuler {
    template <class Real>
    [[gnu::always_inline]] static void step(const Constants<Real>& c, Real drive, Real& v, Real& g) {
        const Real rate = 1 + g;
        const Real target = (c.v_r + drive + g * c.e_k) / rate;
        v = target + (v - target) * std::exp(-rate * c.step);
        g *= c.decay;
    }
};

struct RungeKutta4 {
    template <class Real>
    [[gnu::always_inline]] static void step(const Constants<Real>& c, Real drive, Real& v, Real& g) {
        const Real half = Real(0.5) * c.step;
        const Real g_half = g * c.half_decay;
        const Real g_end = g * c.decay;
        const Real source = c.v_r + drive;
        const Real k1 = source - v - g * (v - c.e_k);
        const Real v2 = v + half * k1;
        const Real k2 = source - v2 - g_half * (v2 - c.e_k);
        const Real v3 = v + half * k2;
        const Real k3 = source - v3 - g_half * (v3 - c.e_k);
        const Real v4 = v + c.step * k3;
        const Real k4 = source - v4 - g_end * (v4 - c.e_k);
        v += c.step * (k1 + 2 * (k2 + k3) + k4) / 6;
        g = g_end;
    }
};

template <class Method, class Real>
[[gnu::always_inline]] inline void step_tile(const Constants<Real>& c, Tile<Real>& t, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
        Real v = t.v[i];
        Real g = t.g[i];
        Method::step(c, t.drive[i], v, g);
        t.next_v[i] = v;
        t.next_g[i] = g;
    }
    for (std::size_t i = 0; i < size; ++i) t.crossed[i] = t.next_v[i] >= t.v_th[i] ? 1 : 0;
}

AFFERENT_CLONES void step_all(Euler, const Constants<double>& c, Tile<double>& t, std::size_t size) {
    step_tile<Euler>(c, t, size);
}
AFFERENT_CLONES void step_all(ExponentialEuler, const Constants<double>& c, Tile<double>& t,
                              std::size_t size) {
    step_tile<ExponentialEuler>(c, t, size);
}
AFFERENT_CLONES void step_all(RungeKutta4, const Constants<double>& c, Tile<double>& t, std::size_t size) {
    step_tile<RungeKutta4>(c, t, size);
}
AFFERENT_CLONES void step_all(RungeKutta4, const Constants<float>& c, Tile<float>& t, std::size_t size) {
    step_tile<RungeKutta4>(c, t, size);
}

template <class Method, class Real>
class SteppingSolver final : public Solver {
  public:
    SteppingSolver(Crossing crossing, double step_ms) : crossing_(crossing), step_ms_(step_ms) {}

    void run(const Workload& workload, Trains& trains) override {
        const LifParameters& first = workload.parameters.front();
        for (const LifParameters& each : workload.parameters) {
            if (each.refractory_ms > 0) throw Unserved("has no refractory period");
            if (each.tau_m_ms != first.tau_m_ms || each.tau_g_ms != first.tau_g_ms ||
                each.v_r_mv != first.v_r_mv || each.e_k_mv != first.e_k_mv)
                throw Unserved("takes neurons that differ in threshold and delta_g only");
        }
        const double span_ms = Milliseconds(workload.until - scene_start).count();
        if (span_ms / step_ms_ * static_cast<double>(workload.neurons) > workload.most_steps)
            throw Unserved("takes too many steps");
        for (std::size_t begin = 0; begin < workload.neurons; begin += tile)
            run_tile(workload, begin, trains);
    }

  private:
    void run_tile(const Workload& workload, std::size_t begin, Trains& trains) {
        const std::size_t size = std::min(tile, workload.neurons - begin);
        const LifParameters& first = workload.of(begin);
        const double tau_ns = first.tau_m_ms * 1e6;
        for (std::size_t i = 0; i < size; ++i) {
            const LifParameters& own = workload.of(begin + i);
            tile_.v[i] = static_cast<Real>(own.v_r_mv);
            tile_.g[i] = 0;
            tile_.v_th[i] = static_cast<Real>(own.v_th_mv);
            tile_.delta_g[i] = static_cast<Real>(own.delta_g);
        }
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            for (std::size_t i = 0; i < size; ++i)
                tile_.drive[i] = static_cast<Real>(workload.drive_mv(row, begin + i));
            const double span_ns = Interval(workload.end(row) - workload.times[row]).count();
            const double steps = std::max(1.0, std::ceil(span_ns / (step_ms_ * 1e6) - 1e-9));
            const double step_ns = span_ns / steps;
            constants_ = constants(first, step_ns / tau_ns);
            for (double k = 0; k < steps; ++k) {
                step_all(Method(), constants_, tile_, size);
                if (std::memchr(tile_.crossed.data(), 1, size) != nullptr) {
                    for (std::size_t i = 0; i < size; ++i)
                        if (tile_.crossed[i] != 0)
                            cross(first, i, {workload.times[row], Interval(k * step_ns)}, tau_ns,
                                  workload.max_spikes, trains[begin + i]);
                }
                std::swap(tile_.v, tile_.next_v);
                std::swap(tile_.g, tile_.next_g);
            }
        }
    }

    static Constants<Real> constants(const LifParameters& p, double step) {
        const double a = p.tau_g_ms / p.tau_m_ms;
        return {static_cast<Real>(p.v_r_mv),
                static_cast<Real>(p.e_k_mv),
                static_cast<Real>(step),
                static_cast<Real>(std::exp(-step / a)),
                static_cast<Real>(std::exp(-step / (2 * a))),
                static_cast<Real>(1 - step / a)};
    }

    void cross(const LifParameters& p, std::size_t i, SpikeTime begin, double tau_ns, std::size_t max_spikes,
               Train& train) {
        Real v = tile_.v[i];
        Real g = tile_.g[i];
        double left = static_cast<double>(constants_.step);
        const double whole = left;
        for (int spikes = 0;; ++spikes) {
            // Beyond the limit of stability, a step is so wrong that the rest of it crosses again and again.
            if (spikes == most_spikes_in_a_step) throw Unserved("is unstable at this step");
            double span = left;
            Constants<Real> part = constants_;
            if (crossing_ != Crossing::at_end) {
                span = root(p, i, v, g, left);
                part = constants(p, span);
            }
            if (train.size() < max_spikes)
                train.push_back({begin.near, begin.rest + Interval((whole - left + span) * tau_ns)});
            if (crossing_ != Crossing::corrected) {
                tile_.next_v[i] = static_cast<Real>(p.v_r_mv);
                tile_.next_g[i] += tile_.delta_g[i];
                return;
            }
            Method::step(part, tile_.drive[i], v, g);
            v = static_cast<Real>(p.v_r_mv);
            g += tile_.delta_g[i];
            left -= span;
            Real v_end = v;
            Real g_end = g;
            Method::step(constants(p, left), tile_.drive[i], v_end, g_end);
            if (!(v_end >= tile_.v_th[i]) || left <= 0 || train.size() >= max_spikes) {
                tile_.next_v[i] = v_end;
                tile_.next_g[i] = g_end;
                return;
            }
        }
    }

    // The crossing within the step: on a straight line for Euler, otherwise by bracketed Newton on the length
    // of the step.
    double root(const LifParameters& p, std::size_t i, Real v0, Real g0, double length) {
        const auto v_after = [&](double span, Real& g) {
            Real v = v0;
            g = g0;
            Method::step(constants(p, span), tile_.drive[i], v, g);
            return v;
        };
        Real g = 0;
        double low = 0;
        double high = length;
        const Real v1 = v_after(length, g);
        double span = length * static_cast<double>((tile_.v_th[i] - v0) / (v1 - v0));
        if (std::is_same_v<Method, Euler>) return std::clamp(span, low, high);
        for (int step = 0; step < 30; ++step) {
            if (!(span > low && span < high)) span = 0.5 * (low + high);
            const Real v = v_after(span, g);
            (v < tile_.v_th[i] ? low : high) = span;
            const Real slope =
                static_cast<Real>(p.v_r_mv) - v + tile_.drive[i] - g * (v - static_cast<Real>(p.e_k_mv));
            const double change = static_cast<double>((v - tile_.v_th[i]) / slope);
            span -= change;
            if (!(std::abs(change) > 4 * static_cast<double>(std::numeric_limits<Real>::epsilon()) * length))
                break;
        }
        return std::clamp(span, low, high);
    }

    Crossing crossing_;
    double step_ms_;
    Constants<Real> constants_{};
    Tile<Real> tile_{};
};

}  // namespace

std::vector<std::string> stepping_solver_names() {
    std::vector<std::string> names;
    for (const char* method : {"euler", "exponential-euler", "rk4", "rk4-float"})
        for (const char* crossing : {"", "-interpolated", "-corrected"})
            names.push_back(std::string(method) + crossing);
    return names;
}

std::unique_ptr<Solver> make_stepping_solver(const SolverSpec& spec) {
    std::string method = spec.name;
    Crossing crossing = Crossing::at_end;
    const auto cut = [&](const std::string& suffix, Crossing meaning) {
        if (!method.ends_with(suffix)) return;
        method.resize(method.size() - suffix.size());
        crossing = meaning;
    };
    cut("-interpolated", Crossing::interpolated);
    cut("-corrected", Crossing::corrected);
    const double step_ms = spec.setting > 0 ? spec.setting : 0.1;
    if (method == "euler") return std::make_unique<SteppingSolver<Euler, double>>(crossing, step_ms);
    if (method == "exponential-euler")
        return std::make_unique<SteppingSolver<ExponentialEuler, double>>(crossing, step_ms);
    if (method == "rk4") return std::make_unique<SteppingSolver<RungeKutta4, double>>(crossing, step_ms);
    if (method == "rk4-float") return std::make_unique<SteppingSolver<RungeKutta4, float>>(crossing, step_ms);
    return nullptr;
}

}  // namespace afferent::bench
