// What a scene needs, what is left out and why, and what to expect of it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct Plan {
    struct Part {
        std::string name;
        bool built;
        std::string reason;  // for either
    };
    std::vector<Part> parts;

    std::size_t threads;
    std::uint32_t neurons;
    std::uint32_t elements;
    double bytes_per_neuron;   // of state, encoder and queue
    double bytes_per_element;  // the same, over elements that several neurons may read

    // No more than this can come, whatever touches the sensors: every neuron firing as one that does not
    // adapt would at its full scale. Infinite where nothing but the spike limit bounds it.
    double events_per_second;
    // Of packets with these events, framing included; 0 where the link carries none.
    double bytes_per_second;
    // Of an untouched hand: heartbeats alone.
    double resting_bytes_per_second;
};

Plan make_plan(const Scene& scene);

}  // namespace afferent
