// The conditions of a trial: what the gain goes by.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct Condition {
    enum class Feed {
        nothing,        // the gain stays 1
        samples,        // the grip force, from the sensors' samples
        events,         // the spikes of the scene's neurons, through one of the decoders
        send_on_delta,  // an event for each change of an element's force
    };
    std::string name;
    Feed feed = Feed::nothing;

    // The scene with the decoder of this condition; one of the same kind keeps the scene's own parameters.
    Scene applied_to(const Scene& scene) const;
};

// All there are, by name:
//
//     none                                        no feedback
//     force                                       samples
//     rate                                        the paper's: the spike rate in a window of 60 ms
//     exponential, interval, inversion, filter    the other decoders
//     send_on_delta                               onset and offset events (Osborn et al. 2016)
const std::vector<Condition>& conditions();
std::vector<std::string> condition_names();
// Throws SceneError, which names the nearest.
const Condition& condition(std::string_view name);

}  // namespace afferent
