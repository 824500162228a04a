// Replays a recording: as `afferent replay`, or as a hand whose link is a file.
#pragma once

#include <optional>
#include <string>

#include "afferent/apps/live_view.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct ReplayOptions {
    std::string file;
    std::string out;
    // Times the pace of the wall clock; nothing: as fast as it goes.
    std::optional<double> speed = 1;
    double from_s = 0;
    // Used in place of the recorded scene's decoder.
    std::optional<scene::Decoder> decoder = {};
    // Whose outputs are opened.
    std::optional<Scene> outputs = {};
    bool json = false;
    ViewOptions view = {};
};

// A recording of another scene than the expected one is refused. Throws Failure or Interrupted.
void replay_recording(const ReplayOptions& options, const Scene* expected = nullptr);

}  // namespace afferent
