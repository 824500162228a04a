// A new value for a field of a scene, named by its path. Included with scene.hpp by programs that vary
// scenes.
#pragma once

#include <string>
#include <string_view>

namespace afferent {

// The value is written as in the text of a scene, but strings need no quotes:
//
//     neuron.delta_g=0.1                 in every patch: what is no field of a scene is one of its patches
//     patch[thumb].sensor.rate_hz=100    in the patch of that name; patch[0]: by its place
//     decoder=filter                     the alternative; its other fields keep their values
//     patch.share=[0.5, 0.3, 0.2]        a list is given whole
//     link.channel={loss: 0.1}           so is a message
//     hand.emg_table=                    as if the scene did not say
struct Setting {
    std::string path;
    std::string value;

    // From "path=value". Throws SceneError where there is no "=".
    static Setting from(std::string_view text);
    std::string text() const { return path + '=' + value; }
    bool operator==(const Setting&) const = default;
};

}  // namespace afferent
