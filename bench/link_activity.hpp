// The events and samples that a link has to carry for some kind of touch.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

using GripForce = std::function<double(TimePoint)>;

struct LinkActivity {
    std::string name;
    std::uint32_t elements = 0;
    std::uint32_t addresses = 0;            // of neurons, where an element may have several
    std::vector<NeuronGroup> neurons = {};  // what both ends of a link know of them
    Duration duration{};
    std::vector<Event> events = {};  // sorted
    // Converter counts, scan by scan, in the mean a frame interval apart. Empty where the events do not come
    // from forces.
    std::vector<std::uint16_t> counts = {};
    Duration frame_interval = 5ms;
    double newtons_per_count = 0;
    double noise_counts = 0;  // of the sensors: the standard deviation of a reading
    // Where it is a scene's under a grip force.
    struct Grip {
        Scene scene;
        GripForce force_n;
    };
    std::optional<Grip> grip = {};

    std::size_t scans() const noexcept { return counts.size() / elements; }
    std::span<const std::uint16_t> scan(std::size_t index) const noexcept {
        return std::span(counts).subspan(index * elements, elements);
    }
    double seconds_long() const noexcept { return seconds(duration); }
};

// Independent neurons that fire at random (Poisson), without forces.
LinkActivity poisson_activity(std::uint32_t elements, double rate_hz, Duration duration, std::uint64_t seed);

// The scene with that many elements, without a link and under a grip force that is given from outside.
// Another number of elements than the scene's own is spread over three patches like its first, with the
// further afferents that read that; each takes a random share, so that no two neurons fire alike.
Scene scaled_scene(const Scene& scene, std::uint32_t elements);

// Its sensors, encoders and neurons under a grip force; at most 4 s where there are more than 10,000
// elements.
LinkActivity grip_activity(const Scene& scene, std::uint32_t elements, std::string name, Duration duration,
                           const GripForce& grip_force_n);

// The scene's neurons under the table that its samples come from, with its own times; nothing where they come
// from elsewhere. Throws std::runtime_error where it cannot be read.
std::optional<LinkActivity> recorded_activity(const Scene& scene);

// The grip force of a run of the scene.
GripForce grip_force_of(const Scene& scene);

}  // namespace afferent
