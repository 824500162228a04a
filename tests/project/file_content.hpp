// The content of a file of the project.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace afferent {

inline std::string content(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

}  // namespace afferent
