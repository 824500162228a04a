#include "afferent/scene/sensor.hpp"

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/scene.hpp"

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

Duration sensor_delay(const Scene& scene) {
    double longest_ms = 0;
    for (const scene::Patch& patch : scene.patches) longest_ms = std::max(longest_ms, patch.sensor.delay_ms);
    return from_milliseconds(longest_ms);
}

}  // namespace afferent
