// The files that are written for a chip: templates, and what stands for the names in them.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace afferent {

struct ExportedFile {
    std::string name;
    std::string text;
};

using Replacements = std::vector<std::pair<std::string, std::string>>;

// The templates of that folder of chip/, in which @name@ is replaced.
std::vector<ExportedFile> filled_templates(std::string_view folder, const Replacements& values);

// A name that ends no comment.
std::string in_a_comment(std::string name);

// Name and content of the templates, which the build puts into the program.
std::span<const std::pair<std::string_view, std::string_view>> chip_templates() noexcept;

}  // namespace afferent
