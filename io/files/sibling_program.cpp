#include "afferent/io/files/sibling_program.hpp"

#include <dlfcn.h>

#include <array>
#include <system_error>

namespace afferent {
namespace {

namespace fs = std::filesystem;

// The file that this code was loaded from: the program's, or a library's or module's.
fs::path loaded_file() {
    Dl_info info{};
    return ::dladdr(reinterpret_cast<void*>(&sibling_program), &info) != 0 && info.dli_fname
               ? fs::path(info.dli_fname)
               : fs::path();
}

}  // namespace

fs::path sibling_program(const std::string& name) {
    std::error_code error;
    for (const fs::path& file : std::array{fs::read_symlink("/proc/self/exe", error), loaded_file()}) {
        const fs::path beside = file.parent_path() / name;
        if (file.has_parent_path() && fs::exists(beside, error)) return beside;
    }
    return name;
}

}  // namespace afferent
