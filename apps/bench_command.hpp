// afferent bench: the benchmarks, each a command of its own.
#pragma once

namespace CLI {
class App;
}

namespace afferent {

void add_bench_command(CLI::App& app);

}  // namespace afferent
