// The afferent program: a thin layer over the library.
#include "afferent/apps/commands.hpp"
#include "afferent/apps/neuron_command.hpp"
#include "bench/solver.hpp"

int main(int argc, char** argv) {
    using namespace afferent;
    return run_program(
        {
            .name = "afferent",
            .help = "Afferent: an event-driven spiking runtime for touch.",
            .footer =
                std::string("Example:\n  afferent run examples/grasp.txtpb --out out/grasp\n\n") + exit_codes,
            .commands =
                {
                    run_command(),
                    view_command(),
                    plan_command(),
                    sweep_command(),
                    tune_command(),
                    tuning_command(),
                    calibrate_command(),
                    inspect_command(),
                    coprocessor_command(),
                    hand_command(),
                    emulate_command(),
                    channel_command(),
                    link_command(),
                    keys_command(),
                    replay_command(),
                    convert_command(),
                    export_command(),
                    movie_command(),
                    trial_command(),
                    neuron_command(
                        {.help = "exact, by prediction, or dense, by a sweep per frame; for other solvers "
                                 "see afferent bench neuron",
                         .make = bench::make_exact_solver}),
                    bench_command(),
                },
        },
        AFFERENT_VERSION, argc, argv);
}
