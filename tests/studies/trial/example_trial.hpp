// The scene of the paper's experiment.
#pragma once

#include <string>

#include "afferent/scene/scene.hpp"

namespace afferent {

inline Scene example_trial() {
    Scene scene = Scene::from_file(std::string(AFFERENT_SOURCE_DIR) + "/examples/trial.txtpb");
    scene.runtime.threads = 1;
    return scene;
}

}  // namespace afferent
