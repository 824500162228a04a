#include "afferent/apps/scene_options.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "afferent/apps/progress.hpp"
#include "afferent/scene/scene_table.hpp"

namespace afferent {

Option set_option(std::vector<std::string>& settings) {
    return option("--set", settings,
                  "In place of a field of the scene: PATH=VALUE, as in neuron.delta_g=0.1 (of every patch), "
                  "patch[thumb].sensor.rate_hz=100 or decoder=filter. May be given several times");
}

std::vector<Setting> settings_of(const std::vector<std::string>& typed) {
    std::vector<Setting> settings;
    for (const std::string& each : typed) settings.push_back(Setting::from(each));
    return settings;
}

std::vector<Option> SceneOptions::followed_by(std::vector<Option> others) {
    std::vector<Option> all{
        positional("SCENE", file, "The scene, a Protobuf text file (see proto/scene.proto)").required(),
        option("--seed", seed, "In place of the scene's seed").not_negative(),
        option(
            "--table", table,
            "In place of the scene's source: a table of force (afferent inspect says what it is taken for)"),
        option("--emg", emg, "In place of the user: a table of the closing EMG"),
        option("--duration", duration_s, "In place of the scene's duration, in seconds").positive(),
        set_option(settings),
    };
    std::ranges::move(of_table.options(), std::back_inserter(all));
    std::ranges::move(others, std::back_inserter(all));
    return all;
}

namespace {

// The table stays on the end of the link where the scene has one.
void set_table(scene::Source& source, const std::string& path) {
    if (!force_table(source)) source = scene::Table();
    scene::Table& table = *force_table(source);
    if (traits_of(source).from == SamplesFrom::hand) {
        table.path = path;
        return;
    }
    // Columns and times are those of another table.
    table = {.path = path,
             .column = table.column,
             .out_of_range = table.out_of_range,
             .between = table.between,
             .unit = table.unit};
}

}  // namespace

Scene SceneOptions::read() const {
    Scene scene = Scene::from_file(file, settings_of(settings));
    if (seed >= 0) scene.seed = static_cast<std::uint64_t>(seed);
    if (duration_s) scene.duration_s = *duration_s;
    if (!table.empty()) set_table(scene.source, std::filesystem::absolute(table).string());
    if (!emg.empty()) {
        if (!scene.hand.emg_table) scene.hand.emg_table.emplace();
        scene.hand.emg_table->path = std::filesystem::absolute(emg).string();
    }
    if (choice_is_of_scene) of_table.apply(scene.source);
    // What the file says has been checked.
    if (!table.empty() || !emg.empty() || duration_s || (choice_is_of_scene && of_table.given()))
        scene.check();
    return scene;
}

Scene SceneOptions::read_to_run() const {
    Scene scene = read();
    if (scene.duration_s) return scene;
    Progress progress("reading the table of forces");
    scene.duration_s = default_duration_s(scene, [&](double fraction) { progress.at(fraction); });
    return scene;
}

}  // namespace afferent
