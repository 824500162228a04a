// What the two commands that run one end of a scene have in common.
#pragma once

#include <string>
#include <vector>

#include "afferent/apps/live_view.hpp"
#include "afferent/apps/scene_options.hpp"

namespace afferent {

struct EndOptions {
    SceneOptions scene;
    std::string out;
    std::string record;
    bool lockstep = false;
    bool json = false;
    ViewOptions view;

    static constexpr const char* example =
        "Example, in two terminals:\n  afferent hand examples/grasp.txtpb --out out/hand\n"
        "  afferent coprocessor examples/grasp.txtpb --out out/coprocessor";

    // The options that fill this in; `files` names what is written to the folder.
    std::vector<Option> list(const std::string& files);
};

}  // namespace afferent
