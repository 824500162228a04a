// The commands of the program afferent-bench, which `afferent bench` starts.
#pragma once

#include "afferent/apps/cli.hpp"

namespace afferent {

Command bench_chip_command();
Command bench_error_command();
Command bench_stability_command();
Command bench_latency_command();
Command bench_bandwidth_command();
Command bench_decoding_command();
Command bench_scale_command();
Command bench_faults_command();

}  // namespace afferent
