// The program afferent-bench: what `afferent bench` runs. A program of its own, because it takes competitors'
// solvers and references that nothing else needs.
#include "afferent/apps/bench_commands.hpp"
#include "afferent/apps/neuron_command.hpp"
#include "bench/solver.hpp"

namespace {

std::string solver_help() {
    std::string names;
    for (const std::string& name : afferent::bench::solver_names())
        names += (names.empty() ? "" : ", ") + name;
    return "One of " + names + "; after a colon a step in ms or a tolerance, as in euler:0.1";
}

}  // namespace

int main(int argc, char** argv) {
    using namespace afferent;
    return run_program(
        {
            .name = "afferent bench",
            .help = "Measure, and check what is measured",
            .footer = "Example:\n  afferent bench stability --quick",
            .commands =
                {
                    bench_error_command(),
                    bench_stability_command(),
                    bench_latency_command(),
                    bench_bandwidth_command(),
                    bench_decoding_command(),
                    bench_scale_command(),
                    bench_faults_command(),
                    bench_chip_command(),
                    neuron_command({solver_help(), bench::make_solver, "afferent bench neuron"}),
                },
        },
        AFFERENT_VERSION, argc, argv);
}
