// Goes on as one of the programs that are installed beside this one.
#pragma once

#include <string>
#include <vector>

namespace afferent {

// Replaces this process by that program. Throws Failure where it cannot be started: `absent` says what takes
// it, and how it is built.
[[noreturn]] void become_sibling(const std::string& name, const std::vector<std::string>& arguments,
                                 const std::string& absent);

}  // namespace afferent
