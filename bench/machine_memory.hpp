// What the machine's memory gives, and how much of it a population takes.
#pragma once

#include <cstddef>

namespace afferent::bench {

// Bytes per second, read and written together, at which so many threads sweep over arrays that no cache
// holds: each number is read, changed and written in place, as the state of a population is. The best of
// five sweeps.
double memory_bytes_per_s(std::size_t threads, std::size_t bytes);

// What the process has in memory, after returning to the system what it has freed.
std::size_t resident_bytes();

}  // namespace afferent::bench
