#include "afferent/apps/scene_file.hpp"

#include <cerrno>
#include <fstream>
#include <system_error>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/scene_paths.hpp"

namespace afferent {

void write_scene(Scene scene, const std::string& made_by, const std::filesystem::path& file,
                 const std::filesystem::path& folder) {
    move_inputs(scene, folder);
    errno = 0;
    std::ofstream out(file);
    out << "# " << scene.file << ", " << made_by << '\n' << scene.text(Scene::TextLayout::field_a_line);
    out.close();
    if (!out)
        throw Failure(file.string() + ": cannot be written" +
                      (errno != 0 ? ": " + std::generic_category().message(errno) : ""));
}

}  // namespace afferent
