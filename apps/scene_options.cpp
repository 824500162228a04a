#include "afferent/apps/scene_options.hpp"

#include <iterator>

namespace afferent {

std::vector<Option> SceneOptions::followed_by(std::vector<Option> others) {
    std::vector<Option> all{
        positional("SCENE", file, "The scene, a Protobuf text file (see proto/scene.proto)").required(),
        option("--seed", seed, "In place of the scene's seed").not_negative(),
        option("--table", table, "In place of the scene's source: a CSV table of force"),
        option("--emg", emg, "In place of the user: a CSV table of the closing EMG"),
    };
    std::move(others.begin(), others.end(), std::back_inserter(all));
    return all;
}

Scene SceneOptions::read() const {
    Scene scene = Scene::from_file(file);
    if (seed >= 0) scene.set_seed(static_cast<std::uint64_t>(seed));
    if (!table.empty()) scene.set_table(table);
    if (!emg.empty()) scene.set_emg_table(emg);
    return scene;
}

}  // namespace afferent
