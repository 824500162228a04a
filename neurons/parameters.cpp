#include "afferent/neurons/parameters.hpp"

#include <cmath>
#include <sstream>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

void LifParameters::check() const {
    require(tau_m_ms > 0, "tau_m_ms", "> 0", tau_m_ms);
    require(tau_g_ms > 0, "tau_g_ms", "> 0", tau_g_ms);
    require(true, "v_r_mv", "finite", v_r_mv);
    require(v_th_mv > v_r_mv, "v_th_mv", "> v_r_mv", v_th_mv);
    require(e_k_mv < v_th_mv, "e_k_mv", "< v_th_mv", e_k_mv);
    // Their differences are finite, too.
    constexpr double greatest_mv = 1e300;
    require(std::abs(v_r_mv) <= greatest_mv, "v_r_mv", "at most 1e300 in size", v_r_mv);
    require(std::abs(v_th_mv) <= greatest_mv, "v_th_mv", "at most 1e300 in size", v_th_mv);
    require(std::abs(e_k_mv) <= greatest_mv, "e_k_mv", "at most 1e300 in size", e_k_mv);
    require(delta_g >= 0, "delta_g", ">= 0", delta_g);
    require(refractory_ms >= 0, "refractory_ms", ">= 0", refractory_ms);
}

LifParameters LifParameters::with_adaptation(double new_delta_g) const noexcept {
    LifParameters changed = *this;
    changed.delta_g = new_delta_g;
    return changed;
}

std::string LifParameters::describe() const {
    std::ostringstream text;
    text << "tau_m_ms " << tau_m_ms << ", tau_g_ms " << tau_g_ms << ", v_r_mv " << v_r_mv << ", v_th_mv "
         << v_th_mv << ", e_k_mv " << e_k_mv << ", delta_g " << delta_g << ", refractory_ms "
         << refractory_ms;
    return text.str();
}

}  // namespace afferent
