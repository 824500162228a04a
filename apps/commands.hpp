// The commands of the program; each is a file of its own.
#pragma once

#include "afferent/apps/cli.hpp"

namespace afferent {

Command run_command();
Command plan_command();
Command sweep_command();
Command tune_command();
Command tuning_command();
Command calibrate_command();
Command inspect_command();
Command coprocessor_command();
Command hand_command();
Command emulate_command();
Command channel_command();
Command link_command();
Command keys_command();
Command replay_command();
Command convert_command();
Command export_command();
Command movie_command();
Command trial_command();
Command view_command();
Command bench_command();

}  // namespace afferent
