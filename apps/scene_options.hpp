// The scene of a command: its file, and what the command line puts in place of parts of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/apps/cli.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct SceneOptions {
    std::string file;
    std::int64_t seed = -1;  // < 0: the scene's own
    std::string table;
    std::string emg;
    std::vector<std::string> settings;
    std::optional<double> duration_s;

    // The options that fill this in, followed by the command's others. This must not move until it is read.
    std::vector<Option> followed_by(std::vector<Option> others);
    Scene read() const;
};

}  // namespace afferent
