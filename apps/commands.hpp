// The commands of the program; each is a file of its own.
#pragma once

namespace CLI {
class App;
}

namespace afferent {

void add_run_command(CLI::App& app);
void add_plan_command(CLI::App& app);
void add_tune_command(CLI::App& app);
void add_coprocessor_command(CLI::App& app);
void add_hand_command(CLI::App& app);
void add_channel_command(CLI::App& app);
void add_link_command(CLI::App& app);
void add_keys_command(CLI::App& app);
void add_replay_command(CLI::App& app);
void add_convert_command(CLI::App& app);
// Below `bench`, which is made where it is not there yet.
void add_bench_bandwidth_command(CLI::App& app);

}  // namespace afferent
