// afferent bench: starts the benchmarks, which are a program of their own.
#include <memory>
#include <string>
#include <vector>

#include "afferent/apps/become_sibling.hpp"
#include "afferent/apps/commands.hpp"

namespace afferent {

Command bench_command() {
    const auto arguments = std::make_shared<std::vector<std::string>>();
    return {
        .name = "bench",
        .help = "Measure, and check what is measured",
        .rest = arguments.get(),
        .run =
            [arguments] {
                become_sibling("afferent-bench", *arguments,
                               "the benchmarks are a program of their own, afferent-bench, which is neither "
                               "beside this one "
                               "nor in PATH. Build it: scripts/build.sh release afferent-bench");
            },
    };
}

}  // namespace afferent
