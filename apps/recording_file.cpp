#include "afferent/apps/recording_file.hpp"

#include "afferent/apps/failure.hpp"

namespace afferent {

std::optional<std::filesystem::path> recording_file(const Plan& plan, const std::string& record) {
    const auto* file = std::get_if<scene::File>(&plan.scene.link.transport);
    if (file && !record.empty()) throw Failure("--record: the scene's link is a recording already");
    if (file) return plan.scene.resolve(file->path);
    if (record.empty()) return std::nullopt;
    if (plan.in_process())
        throw Failure(
            "--record: a recording is of packets, and this scene's link is in process, without any. Give the "
            "scene "
            "a link, as in: link { tcp {} }");
    return record;
}

}  // namespace afferent
