#include "bench/machine_memory.hpp"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <vector>

#include "afferent/runtime/parallel.hpp"

namespace afferent::bench {

double memory_bytes_per_s(std::size_t threads, std::size_t bytes) {
    const std::size_t count = bytes / sizeof(double) / threads;
    std::vector<std::vector<double>> arrays(threads);
    Workers workers(threads);
    workers.run(threads, [&](std::size_t i) { arrays[i].assign(count, 1.0); });
    double best = 0;
    for (int sweep = 0; sweep < 5; ++sweep) {
        const auto begin = std::chrono::steady_clock::now();
        workers.run(threads, [&](std::size_t i) {
            for (double& each : arrays[i]) each = 0.5 * each + 0.25;
        });
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        best = std::max(best, 2.0 * static_cast<double>(threads * count * sizeof(double)) / took.count());
    }
    return best;
}

std::size_t resident_bytes() {
    ::malloc_trim(0);
    std::ifstream statm("/proc/self/statm");
    std::size_t pages = 0;
    statm >> pages >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace afferent::bench
