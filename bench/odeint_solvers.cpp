// Boost.Odeint: Dormand–Prince and, for stiff neurons, Rosenbrock, both with dense output and root finding.
#include <array>
#include <boost/math/tools/roots.hpp>
#include <boost/numeric/odeint/util/bind.hpp>
#include <boost/numeric/odeint/util/unwrap_reference.hpp>
// These headers need those above, but do not include them.
#include <boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>

#include "bench/rosenbrock_stepper.hpp"
#include "bench/solver.hpp"

namespace afferent::bench {
namespace {

namespace odeint = boost::numeric::odeint;

// Time in units of tau_m; x = (v, g).
struct Membrane {
    double v_r, e_k, a, drive;

    template <class State, class Change>
    void derivative(const State& x, Change& change) const {
        change[0] = v_r - x[0] + drive - x[1] * (x[0] - e_k);
        change[1] = -x[1] / a;
    }
};

class DormandPrince {
  public:
    using State = std::array<double, 2>;
    explicit DormandPrince(double tolerance)
        : stepper_(odeint::make_dense_output(tolerance, tolerance, odeint::runge_kutta_dopri5<State>())) {}

    void start(const State& x, double t, double step) { stepper_.initialize(x, t, step); }
    void advance(const Membrane& membrane) {
        stepper_.do_step([&](const State& x, State& change, double) { membrane.derivative(x, change); });
    }
    void at(double t, State& x) const { stepper_.calc_state(t, x); }
    double time() const { return stepper_.current_time(); }
    double before() const { return stepper_.previous_time(); }
    const State& now() const { return stepper_.current_state(); }

  private:
    odeint::result_of::make_dense_output<odeint::runge_kutta_dopri5<State>>::type stepper_;
};

class Rosenbrock {
  public:
    using State = std::array<double, 2>;
    explicit Rosenbrock(double tolerance) : stepper_(tolerance) {}

    void start(const State& x, double t, double step) { stepper_.start(x, t, step); }
    void advance(const Membrane& m) { stepper_.advance(m.v_r, m.e_k, m.a, m.drive); }
    void at(double t, State& x) { x = stepper_.at(t); }
    double time() const { return stepper_.time(); }
    double before() const { return stepper_.before(); }
    State now() const { return stepper_.now(); }

  private:
    RosenbrockStepper stepper_;
};

template <class Stepper>
class OdeintSolver final : public Solver {
  public:
    explicit OdeintSolver(double tolerance) : tolerance_(tolerance) {}

    void run(const Workload& workload, Trains& trains) override {
        for (std::size_t i = 0; i < workload.neurons; ++i) run_one(workload, i, trains[i]);
    }

  private:
    void run_one(const Workload& workload, std::size_t neuron, Train& train) {
        const LifParameters& p = workload.of(neuron);
        if (p.refractory_ms > 0) throw Unserved("has no refractory period");
        const double tau_ns = p.tau_m_ms * 1e6;
        Membrane membrane{p.v_r_mv, p.e_k_mv, p.tau_g_ms / p.tau_m_ms, 0};
        std::array<double, 2> x{p.v_r_mv, 0};
        std::array<double, 2> inside = x;
        Stepper stepper(tolerance_);
        double step = 0.01;
        double steps = 0;
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            membrane.drive = workload.drive_mv(row, neuron);
            const double end = Interval(workload.end(row) - workload.times[row]).count() / tau_ns;
            double now = 0;
            while (now < end && train.size() < workload.max_spikes) {
                stepper.start(x, now, std::min(step, end - now));
                for (;;) {
                    try {
                        stepper.advance(membrane);
                    } catch (const std::exception& error) {
                        throw Unserved(error.what());
                    }
                    if (++steps > workload.most_steps) throw Unserved("takes too many steps");
                    if (!std::isfinite(stepper.now()[0])) throw Unserved("diverges");
                    const double reached = std::min(stepper.time(), end);
                    stepper.at(reached, x);
                    if (x[0] >= p.v_th_mv) {
                        now = root(stepper, now, reached, p.v_th_mv, inside);
                        train.push_back({workload.times[row], Interval(now * tau_ns)});
                        x[0] = p.v_r_mv;
                        x[1] = inside[1] + p.delta_g;
                        break;
                    }
                    step = stepper.time() - stepper.before();
                    if (stepper.time() >= end) {
                        now = end;
                        break;
                    }
                }
            }
        }
    }

    static double root(Stepper& stepper, double begin, double end, double v_th,
                       std::array<double, 2>& inside) {
        const auto over = [&](double t) {
            stepper.at(t, inside);
            return inside[0] - v_th;
        };
        const double low = std::max(stepper.before(), begin);
        double t = end;
        if (over(low) < 0) {
            std::uintmax_t most = 100;
            const auto bracket = boost::math::tools::toms748_solve(
                over, low, end, boost::math::tools::eps_tolerance<double>(52), most);
            t = 0.5 * (bracket.first + bracket.second);
        } else {
            t = low;
        }
        over(t);
        return t;
    }

    double tolerance_;
};

}  // namespace

std::vector<std::string> odeint_solver_names() { return {"dopri5", "rosenbrock"}; }

std::unique_ptr<Solver> make_odeint_solver(const SolverSpec& spec) {
    const double tolerance = spec.setting > 0 ? spec.setting : 1e-6;
    if (spec.name == "dopri5") return std::make_unique<OdeintSolver<DormandPrince>>(tolerance);
    if (spec.name == "rosenbrock") return std::make_unique<OdeintSolver<Rosenbrock>>(tolerance);
    return nullptr;
}

}  // namespace afferent::bench
