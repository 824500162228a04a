#include "afferent/scene/sensor.hpp"

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

void check(const scene::Sensor& sensor, std::uint32_t elements) {
    const Sensor made(sensor);
    for (const std::uint32_t element : sensor.dead_element)
        require(element < elements, "dead_element", "below the number of elements", element);
    for (const scene::StuckElement& stuck : sensor.stuck_element) {
        require(stuck.element < elements, "stuck_element.element", "below the number of elements",
                stuck.element);
        require(made.within_range(stuck.force_n), "stuck_element.force_n", "0 to full_scale_n",
                stuck.force_n);
    }
}

}  // namespace afferent
