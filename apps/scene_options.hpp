// The scene of a command: its file, and what the command line puts in place of parts of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/apps/cli.hpp"
#include "afferent/apps/table_choice.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// --set, given any number of times; what it fills holds the settings as they were typed.
Option set_option(std::vector<std::string>& settings);
// Throws SceneError.
std::vector<Setting> settings_of(const std::vector<std::string>& typed);

struct SceneOptions {
    std::string file;
    std::int64_t seed = -1;  // < 0: the scene's own
    std::string table;
    std::string emg;
    std::vector<std::string> settings;
    std::optional<double> duration_s;
    TableChoice of_table;
    bool choice_is_of_scene = true;  // or of a table that the command itself reads

    // The options that fill this in, followed by the command's others. This must not move until it is read.
    std::vector<Option> followed_by(std::vector<Option> others);
    Scene read() const;
    // The same, with a duration: that of its table where it says none, which takes a while to read.
    Scene read_to_run() const;
    // Whether anything is put in place of what the file says.
    bool replaces() const noexcept {
        return seed >= 0 || !table.empty() || !emg.empty() || !settings.empty() || duration_s;
    }
};

}  // namespace afferent
