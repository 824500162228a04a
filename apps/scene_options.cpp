#include "afferent/apps/scene_options.hpp"

#include <CLI/CLI.hpp>

namespace afferent {

void SceneOptions::add_to(CLI::App& command) {
    command.add_option("SCENE", file, "The scene, a Protobuf text file (see proto/scene.proto)")->required();
    command.add_option("--seed", seed, "In place of the scene's seed")->check(CLI::NonNegativeNumber);
    command.add_option("--table", table, "In place of the scene's source: a CSV table of force");
    command.add_option("--emg", emg, "In place of the user: a CSV table of the closing EMG");
}

Scene SceneOptions::read() const {
    Scene scene = Scene::from_file(file);
    if (seed >= 0) scene.set_seed(static_cast<std::uint64_t>(seed));
    if (!table.empty()) scene.set_table(table);
    if (!emg.empty()) scene.set_emg_table(emg);
    return scene;
}

}  // namespace afferent
