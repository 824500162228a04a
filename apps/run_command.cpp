// afferent run: a whole scene in one process, or started by mpirun in several.
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "afferent/apps/become_sibling.hpp"
#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/run_scene.hpp"

namespace afferent {
namespace {

// What mpirun tells a process that it starts; Open MPI's names. 0 where it has not.
unsigned long told_by_mpirun(const char* name) {
    const char* value = std::getenv(name);
    return value ? std::strtoul(value, nullptr, 10) : 0;
}

// Only a program of its own loads MPI. That it is absent is said once, by rank 0.
void become_rank(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "run");
    try {
        become_sibling("afferent-ranks", arguments,
                       "a run in several processes takes the program afferent-ranks, which is neither beside "
                       "this one nor in PATH. Build it: scripts/install-dependencies.sh mpi && "
                       "scripts/build.sh release -DAFFERENT_MPI=ON afferent-ranks");
    } catch (const Failure&) {
        if (told_by_mpirun("OMPI_COMM_WORLD_RANK") == 0) throw;
    }
}

}  // namespace

Command run_command() {
    if (told_by_mpirun("OMPI_COMM_WORLD_SIZE") > 1) {
        const auto arguments = std::make_shared<std::vector<std::string>>();
        return {
            .name = "run",
            .help = "Run a scene in virtual time, or paced by the wall clock, in several processes",
            .rest = arguments.get(),
            .run = [arguments] { become_rank(*arguments); },
        };
    }
    const auto options = std::make_shared<RunOptions>();
    return {
        .name = "run",
        .help = "Run a scene in virtual time, or paced by the wall clock",
        .footer =
            "Example:\n  afferent run examples/grasp.txtpb --out out/grasp\n\n"
            "In several processes, on one machine or many (docs/ranks.md):\n"
            "  mpirun -n 4 afferent run SCENE",
        .options = options->followed_by(),
        .run =
            [options] {
                catch_interrupts();
                run_scene(*options, make_plan(options->scene.read_to_run()));
            },
    };
}

}  // namespace afferent
