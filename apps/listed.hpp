// An option that holds a list, separated by commas.
#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "afferent/apps/failure.hpp"

namespace afferent {

// Throws Failure where something stands there twice.
inline std::vector<std::string> listed(const std::string& option, const std::string& list) {
    std::vector<std::string> names;
    std::istringstream in(list);
    for (std::string each; std::getline(in, each, ',');) {
        if (std::ranges::find(names, each) != names.end())
            throw Failure(option + ": \"" + each + "\" stands there twice");
        names.push_back(each);
    }
    return names;
}

}  // namespace afferent
