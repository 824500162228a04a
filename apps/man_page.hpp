// Man pages of a program, from the same values that its help comes from.
#pragma once

#include <string>
#include <vector>

#include "afferent/apps/cli.hpp"

namespace afferent {

struct ManPage {
    std::string name;  // afferent-run: that of the file, without .1
    std::string text;  // for groff -man
};

// One page for the program and one for each of its commands, in their order. A command that is a program of
// its own writes its pages itself.
std::vector<ManPage> man_pages(const Command& program, const std::string& version);

// "afferent link status" as a file or a function is called: afferent-link-status.
std::string joined(const std::string& path, char between);

}  // namespace afferent
