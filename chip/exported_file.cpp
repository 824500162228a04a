#include "afferent/chip/exported_file.hpp"

namespace afferent {

std::vector<ExportedFile> filled_templates(std::string_view folder, const Replacements& values) {
    std::vector<ExportedFile> files;
    for (const auto& [name, content] : chip_templates()) {
        if (!name.starts_with(folder)) continue;
        std::string text(content);
        for (const auto& [place, value] : values) {
            const std::string mark = "@" + place + "@";
            for (std::size_t at = 0; (at = text.find(mark, at)) != std::string::npos; at += value.size())
                text.replace(at, mark.size(), value);
        }
        files.push_back({std::string(name.substr(folder.size())), text});
    }
    return files;
}

std::string in_a_comment(std::string name) {
    for (char& c : name)
        if (c == '*' || c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ') c = '_';
    return name;
}

}  // namespace afferent
