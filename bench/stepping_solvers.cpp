// Solvers that step, made as fast as their method allows: structure of arrays in tiles that stay in the
// cache, inner loops and crossings in vectors of the widest instruction set that the machine has, the
// conductance decayed by its exact factor.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "bench/solver.hpp"
#include "bench/stepping_kernel.hpp"

namespace afferent::bench {
namespace {

using namespace stepping;

// How a crossing inside a step is treated.
enum class Crossing {
    at_end,        // spike and reset are at the end of the step
    interpolated,  // the spike is at the crossing, the reset at the end of the step
    corrected,     // both are at the crossing, and the rest of the step is computed again
};

constexpr int most_spikes_in_a_step = 1000;

template <class Real>
class SteppingSolver final : public Solver {
  public:
    SteppingSolver(Method method, Crossing crossing, double step_ms)
        : crossing_(crossing), step_ms_(step_ms) {
        choose(method, kernel_);
    }

    void run(const Workload& workload, Trains& trains) override {
        carry_out(workload, [&](std::size_t neuron, TimePoint row, double rest_ns) {
            trains[neuron].push_back({row, Interval(rest_ns)});
        });
    }
    std::size_t count(const Workload& workload) override {
        std::size_t spikes = 0;
        carry_out(workload, [&](std::size_t, TimePoint, double) { ++spikes; });
        return spikes;
    }

  private:
    template <class Sink>
    void carry_out(const Workload& workload, Sink&& sink) {
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
        for (std::size_t begin = 0; begin < workload.neurons; begin += tile_size)
            run_tile(workload, begin, sink);
    }

    template <class Sink>
    void run_tile(const Workload& workload, std::size_t begin, Sink& sink) {
        const std::size_t size = std::min(tile_size, workload.neurons - begin);
        const LifParameters& first = workload.of(begin);
        const double tau_ns = first.tau_m_ms * 1e6;
        const double rest_mv = first.v_r_mv - first.e_k_mv;
        tile_.w->fill(static_cast<Real>(rest_mv));
        tile_.g->fill(0);
        tile_.b.fill(static_cast<Real>(rest_mv));
        tile_.threshold.fill(std::numeric_limits<Real>::max());
        for (std::size_t i = 0; i < size; ++i) {
            const LifParameters& own = workload.of(begin + i);
            tile_.threshold[i] = static_cast<Real>(own.v_th_mv - own.e_k_mv);
            tile_.delta_g[i] = static_cast<Real>(own.delta_g);
        }
        fired_.fill(0);
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            kernel_.set_drives(workload.row(row).data() + begin, rest_mv, size, tile_);
            const double span_ns = Interval(workload.end(row) - workload.times[row]).count();
            const double steps = std::max(1.0, std::ceil(span_ns / (step_ms_ * 1e6) - 1e-9));
            const double step_ns = span_ns / steps;
            const Constants<Real> constants = constants_of(first, step_ns / tau_ns);
            for (double k = 0; k < steps; ++k) {
                kernel_.step(constants, size, tile_, crossings_);
                const auto fire = [&](std::size_t i, double part) {
                    if (fired_[i]++ < workload.max_spikes)
                        sink(begin + i, workload.times[row], k * step_ns + part * tau_ns);
                };
                if (crossings_.count > 0) cross(constants, workload.max_spikes, fire);
                std::swap(tile_.w, tile_.next_w);
                std::swap(tile_.g, tile_.next_g);
            }
        }
    }

    static Constants<Real> constants_of(const LifParameters& p, double step) {
        const double a = p.tau_g_ms / p.tau_m_ms;
        return {.step = static_cast<Real>(step),
                .inverse_a = static_cast<Real>(1 / a),
                .reset = static_cast<Real>(p.v_r_mv - p.e_k_mv),
                .decay = static_cast<Real>(std::exp(-step / a)),
                .half_decay = static_cast<Real>(std::exp(-step / (2 * a))),
                .fall = static_cast<Real>(1 - step / a)};
    }

    template <class Fire>
    void cross(const Constants<Real>& constants, std::size_t max_spikes, const Fire& fire) {
        Crossings<Real>& at = crossings_;
        if (crossing_ != Crossing::at_end) kernel_.resolve(constants, at);
        if (crossing_ != Crossing::corrected) {
            for (std::size_t k = 0; k < at.count; ++k) {
                const std::size_t i = at.index[k];
                fire(i, crossing_ == Crossing::at_end ? constants.step : at.span[k]);
                (*tile_.next_w)[i] = constants.reset;
                (*tile_.next_g)[i] += tile_.delta_g[i];
            }
            return;
        }
        for (int turn = 1;; ++turn) {
            // Those that cross again in what is left of the step move to the front.
            std::size_t again = 0;
            for (std::size_t k = 0; k < at.count; ++k) {
                const std::size_t i = at.index[k];
                fire(i, static_cast<double>(constants.step - at.left[k]));
                if (at.end_w[k] >= at.threshold[k] && at.left[k] > 0 && fired_[i] < max_spikes) {
                    at.move(k, again++);
                } else {
                    (*tile_.next_w)[i] = at.end_w[k];
                    (*tile_.next_g)[i] = at.end_g[k];
                }
            }
            at.count = again;
            if (again == 0) return;
            // Beyond the limit of stability, a step is so wrong that the rest of it crosses again and again.
            if (turn == most_spikes_in_a_step) throw Unserved("is unstable at this step");
            kernel_.resolve(constants, at);
        }
    }

    Crossing crossing_;
    double step_ms_;
    Kernel<Real> kernel_{};
    Tile<Real> tile_{};
    Crossings<Real> crossings_{};
    std::array<std::size_t, tile_size> fired_{};
};

template <class Real>
std::unique_ptr<Solver> make(Method method, Crossing crossing, double step_ms) {
    return std::make_unique<SteppingSolver<Real>>(method, crossing, step_ms);
}

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
    if (method == "euler") return make<double>(Method::euler, crossing, step_ms);
    if (method == "exponential-euler") return make<double>(Method::exponential_euler, crossing, step_ms);
    if (method == "rk4") return make<double>(Method::rk4, crossing, step_ms);
    if (method == "rk4-float") return make<float>(Method::rk4, crossing, step_ms);
    return nullptr;
}

}  // namespace afferent::bench
