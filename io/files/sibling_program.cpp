#include "afferent/io/files/sibling_program.hpp"

#include <system_error>

namespace afferent {

std::filesystem::path sibling_program(const std::string& name) {
    std::error_code error;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    const auto beside = self.parent_path() / name;
    return !error && std::filesystem::exists(beside, error) ? beside : std::filesystem::path(name);
}

}  // namespace afferent
