#include "bench/rosenbrock_stepper.hpp"

#include <boost/numeric/odeint.hpp>
#include <utility>

namespace afferent::bench {
namespace {

namespace odeint = boost::numeric::odeint;
using State = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;
using Controller = odeint::rosenbrock4_controller<odeint::rosenbrock4<double>>;

}  // namespace

class RosenbrockStepper::Stepper : public odeint::rosenbrock4_dense_output<Controller> {
  public:
    explicit Stepper(double tolerance)
        : odeint::rosenbrock4_dense_output<Controller>(Controller(tolerance, tolerance)) {}
};

RosenbrockStepper::RosenbrockStepper(double tolerance) : stepper_(std::make_unique<Stepper>(tolerance)) {}
RosenbrockStepper::~RosenbrockStepper() = default;

void RosenbrockStepper::start(const std::array<double, 2>& x, double t, double step) {
    State state(2);
    state[0] = x[0];
    state[1] = x[1];
    stepper_->initialize(state, t, step);
}

void RosenbrockStepper::advance(double v_r, double e_k, double a, double drive) {
    const auto right = [=](const State& x, State& change, double) {
        change[0] = v_r - x[0] + drive - x[1] * (x[0] - e_k);
        change[1] = -x[1] / a;
    };
    const auto jacobian = [=](const State& x, Matrix& j, double, State& by_time) {
        j(0, 0) = -1 - x[1];
        j(0, 1) = -(x[0] - e_k);
        j(1, 0) = 0;
        j(1, 1) = -1 / a;
        by_time[0] = by_time[1] = 0;
    };
    stepper_->do_step(std::make_pair(right, jacobian));
}

std::array<double, 2> RosenbrockStepper::at(double t) {
    State x(2);
    stepper_->calc_state(t, x);
    return {x[0], x[1]};
}

std::array<double, 2> RosenbrockStepper::now() const {
    const State& x = stepper_->current_state();
    return {x[0], x[1]};
}

double RosenbrockStepper::time() const { return stepper_->current_time(); }
double RosenbrockStepper::before() const { return stepper_->previous_time(); }

}  // namespace afferent::bench
