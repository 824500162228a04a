// The afferent program: a thin layer over the library.
#include <CLI/CLI.hpp>
#include <iostream>

#include "afferent/apps/bench_command.hpp"
#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/neuron_command.hpp"

int main(int argc, char** argv) {
    CLI::App app{"Afferent: an event-driven spiking runtime for touch.", "afferent"};
    app.set_version_flag("--version", AFFERENT_VERSION);
    app.require_subcommand(1);
    app.footer("Example:\n  afferent run examples/grasp.txtpb --out out/grasp");

    afferent::add_run_command(app);
    afferent::add_plan_command(app);
    afferent::add_tune_command(app);
    afferent::add_coprocessor_command(app);
    afferent::add_hand_command(app);
    afferent::add_channel_command(app);
    afferent::add_link_command(app);
    afferent::add_keys_command(app);
    afferent::add_replay_command(app);
    afferent::add_convert_command(app);
    afferent::add_neuron_command(app);
    afferent::add_bench_command(app);
    afferent::add_bench_bandwidth_command(app);
    try {
        app.parse(argc, argv);
        return EXIT_SUCCESS;
    } catch (const CLI::ParseError& error) {
        return app.exit(error);
    } catch (const afferent::Interrupted&) {
        return 130;  // as a shell reports Ctrl-C
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
