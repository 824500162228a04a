// The programs that are installed beside this one.
#pragma once

#include <filesystem>
#include <string>

namespace afferent {

// Its file beside that of this program, or beside the library or module that holds this code; where there is
// none, its name alone, to be looked for in PATH.
std::filesystem::path sibling_program(const std::string& name);

}  // namespace afferent
