// The programs that are installed beside this one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace afferent {

// Its file beside that of this program; where there is none, its name alone, to be looked for in PATH.
std::filesystem::path sibling_program(const std::string& name);

// Replaces this process by that program. Throws Failure where it cannot be started: `absent` says what takes
// it, and how it is built.
[[noreturn]] void become_sibling(const std::string& name, const std::vector<std::string>& arguments,
                                 const std::string& absent);

}  // namespace afferent
