// The scene of a command, with what the command line says in its place.
#pragma once

#include <cstdint>
#include <string>

#include "afferent/scene/scene.hpp"

namespace CLI {
class App;
}

namespace afferent {

struct SceneOptions {
    std::string file;
    std::int64_t seed = -1;
    std::string table;
    std::string emg;

    void add_to(CLI::App& command);
    Scene read() const;
};

}  // namespace afferent
