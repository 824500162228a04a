// A table of the ratios of the propagator from which an interspike interval tells its drive.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace afferent {

// For an interval of s tau_m that ends with the adaptation g, and a = tau_g/tau_m (neurons/propagator.hpp):
//
//     phi = Φ/Ψ,      chi = X/Ψ
//
// Both hardly depend on g once time is counted in membrane times of the adapted neuron, σ = (1 + g) s:
// s phi is nearly σ/(e^σ − 1), and chi/g nearly 1. These two are tabulated over σ/(1 + σ) and g/(1 + g), and
// interpolated by cubics: a drive comes out within 2e-4 of its excess or 1e-6 of the threshold, whichever is
// more. Beyond the table (g > 32) and for a < 8 the propagator itself is asked.
class IntervalTable {
  public:
    struct Ratios {
        double phi;
        double chi;
    };

    explicit IntervalTable(double a);
    // The one for `a`, made if nobody has it: whoever decodes neurons of one ratio shares a table. The one
    // asked for last is kept, so that a scene that is checked, planned and built has it made once. May be
    // called by several threads at once.
    static std::shared_ptr<const IntervalTable> shared(double a);

    // s > 0, g >= 0.
    Ratios operator()(double s, double g) const noexcept;

    double a() const noexcept { return a_; }
    std::size_t bytes() const noexcept { return sizeof(*this) + nodes_.capacity() * sizeof(Ratios); }

  private:
    double a_;
    std::vector<Ratios> nodes_;  // s phi and chi/g, by g and then by σ; none for a < 8
};

}  // namespace afferent
