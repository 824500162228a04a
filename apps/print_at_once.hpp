// Prints without waiting for the reader: output to a terminal that is held (Ctrl-S) or to a full pipe is
// given up.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace afferent {

// False: it has not been taken in full within that time.
bool print_within(int file, std::string_view text, std::chrono::milliseconds patience);

// Prints a line on standard error, or nothing if that would have to wait.
void say(const std::string& line);
// How many lines were not printed.
std::uint64_t unsaid() noexcept;

}  // namespace afferent
