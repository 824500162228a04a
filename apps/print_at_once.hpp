// Prints without waiting for whoever reads: a terminal that is held (Ctrl-S) and a full pipe are given up.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace afferent {

// False: it has not been taken in full within that time.
bool print_within(int file, std::string_view text, std::chrono::milliseconds patience);

// A line on standard error, or nothing where it would have to be waited for.
void say(const std::string& line);
// How many lines were left out.
std::uint64_t unsaid() noexcept;

}  // namespace afferent
