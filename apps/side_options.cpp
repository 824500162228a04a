#include "afferent/apps/side_options.hpp"

#include <CLI/CLI.hpp>

namespace afferent {

void SideOptions::add_to(CLI::App& command, const std::string& writes) {
    scene.add_to(command);
    command.add_option("--out", out, "Folder for " + writes);
    command.add_option("--record", record,
                       "File (.afferent) for the packets and what came of them, to replay");
    command.add_flag("--lockstep", lockstep,
                     "Virtual time, carried by the messages, in place of the wall clock");
    command.add_flag("--json", json, "Print the summary as JSON");
    command.footer(
        "Example, in two terminals:\n  afferent hand examples/grasp.txtpb --out out/hand\n"
        "  afferent coprocessor examples/grasp.txtpb --out out/coprocessor");
}

}  // namespace afferent
