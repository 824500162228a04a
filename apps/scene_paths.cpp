#include "afferent/apps/scene_paths.hpp"

namespace afferent {

namespace fs = std::filesystem;

std::string path_from(const fs::path& folder, const fs::path& file) {
    const fs::path from = fs::absolute(folder.empty() ? "." : folder).lexically_normal();
    return fs::absolute(file).lexically_normal().lexically_proximate(from).string();
}

void move_inputs(Scene& scene, const fs::path& folder) {
    const auto move = [&](std::string& path) {
        if (!path.empty() && fs::path(path).is_relative()) path = path_from(folder, scene.resolve(path));
    };
    if (scene::Table* const table = force_table(scene.source)) move(table->path);
    if (scene.hand.emg_table) move(scene.hand.emg_table->path);
    if (scene.link.keys) move(*scene.link.keys);
    scene.folder = folder;
}

}  // namespace afferent
