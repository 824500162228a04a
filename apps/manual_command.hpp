// afferent manual: man pages and completions, from the help of the program's own commands.
#pragma once

#include <string>

#include "afferent/apps/cli.hpp"

namespace afferent {

// The manual of all commands that the program has when this one runs. The program must not move until then.
Command manual_command(const Command& program, std::string version);

}  // namespace afferent
