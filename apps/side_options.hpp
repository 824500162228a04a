// What the two commands that run one side of a scene have in common.
#pragma once

#include <string>

#include "afferent/apps/scene_options.hpp"

namespace afferent {

struct SideOptions {
    SceneOptions scene;
    std::string out;
    std::string record;
    bool lockstep = false;
    bool json = false;

    // `writes` says what goes to the folder.
    void add_to(CLI::App& command, const std::string& writes);
};

}  // namespace afferent
