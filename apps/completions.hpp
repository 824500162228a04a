// Completions of a program's commands, options and files for the usual shells, from the same values that its
// help comes from.
#pragma once

#include <string>

#include "afferent/apps/cli.hpp"

namespace afferent {

// Scripts that the shell reads; each defines the completion of the program that the command is.
std::string bash_completion(const Command& program);
std::string zsh_completion(const Command& program);
std::string fish_completion(const Command& program);

}  // namespace afferent
