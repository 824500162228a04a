#include "afferent/apps/recording_file.hpp"

#include "afferent/apps/failure.hpp"

namespace afferent {

std::optional<std::filesystem::path> recording_file(const Plan& plan, const std::string& record) {
    const auto of_link = link_file(plan.scene);
    if (of_link && !record.empty()) throw Failure("--record: the scene's link is a recording already");
    if (of_link) return of_link;
    if (record.empty()) return std::nullopt;
    if (plan.in_process())
        throw Failure(
            "--record: a recording is of packets, and this scene's link is in process, without any. Give the "
            "scene "
            "a link, as in: link { tcp {} }");
    return record;
}

}  // namespace afferent
