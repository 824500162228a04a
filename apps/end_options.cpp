#include "afferent/apps/end_options.hpp"

namespace afferent {

std::vector<Option> EndOptions::list(const std::string& files) {
    std::vector<Option> options{
        option("--out", out, "Folder for " + files),
        option("--record", record, "File (.afferent) for the packets and what came of them, to replay"),
        flag("--lockstep", lockstep, "Virtual time, carried by the messages, in place of the wall clock"),
        flag("--json", json, "Print the summary as JSON"),
    };
    for (Option& each : view.list()) options.push_back(std::move(each));
    return scene.followed_by(std::move(options));
}

}  // namespace afferent
