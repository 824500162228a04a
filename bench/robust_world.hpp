// A grip, the sensors and neurons that feel it, and a description of them for the decoder that may be wrong.
#pragma once

#include <string>
#include <vector>

#include "afferent/scene/plan.hpp"
#include "bench/touch.hpp"

namespace afferent {

struct World {
    std::string name;  // of the grip
    GripForce force_n;
    Duration duration;

    // The description that the decoder gets.
    Plan told;
    DecodedAfferents afferents;

    // The real sensors and neurons.
    Plan made;
    // By element: the part of the grip force that it feels. If element_n is not empty, the forces on the
    // elements are those of element_n.
    std::vector<double> share;
    std::vector<GripForce> element_n = {};
    // By element: a factor on the reading of the sensor that `made` describes.
    std::vector<double> gain;
    // By element: the time from which on it reads 0.
    std::vector<TimePoint> dies;

    // The probability that a packet is lost, and the seed that draws the lost ones.
    double lost = 0;
    unsigned draw = 0;

    // Estimates count from this time on; if judged_in_fast_release, only while the force falls by more than
    // 10 N/s and for 50 ms after.
    TimePoint judged_from = scene_start;
    bool judged_in_fast_release = false;
    double unit_n = 1;  // errors are divided by it

    // A world in which the description is right. The scene's link and hand are ignored.
    World(std::string called, const Scene& scene, GripForce grip_n, Duration length);

    std::size_t elements() const noexcept { return share.size(); }
    // The time at this part of the longest stretch over which the force exceeds 30 % of its maximum.
    TimePoint in_the_grip(double part) const;
};

// The events of that world with what the decoder is told, for follow_events(). `share` and `noise_n` stay
// empty: no decoder of events reads them.
TouchedForce touched_force(const World& world);

// By step, whether its estimate counts.
std::vector<bool> judged(const World& world, const std::vector<double>& true_n);

}  // namespace afferent
