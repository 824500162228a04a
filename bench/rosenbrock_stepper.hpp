// Odeint's Rosenbrock stepper for the adapting membrane.
#pragma once

#include <array>
#include <memory>

namespace afferent::bench {

// It is built on uBLAS, which Debian 12's Boost has in a form that C++20 does not compile: it stays behind
// this interface, in C++17. Time in units of tau_m, x = (v, g).
class RosenbrockStepper {
  public:
    explicit RosenbrockStepper(double tolerance);
    ~RosenbrockStepper();

    void start(const std::array<double, 2>& x, double t, double step);
    void advance(double v_r, double e_k, double a, double drive);
    // Between the last two steps.
    std::array<double, 2> at(double t);
    std::array<double, 2> now() const;
    double time() const;
    double before() const;

  private:
    class Stepper;
    std::unique_ptr<Stepper> stepper_;
};

}  // namespace afferent::bench
