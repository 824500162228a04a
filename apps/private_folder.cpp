#include "afferent/apps/private_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace afferent {

std::optional<std::filesystem::path> private_folder() {
    const char* const set = std::getenv("XDG_RUNTIME_DIR");
    const std::filesystem::path runtime = set ? set : "";
    const auto path = runtime.is_absolute() ? runtime / "afferent"
                                            : std::filesystem::temp_directory_path() /
                                                  ("afferent-" + std::to_string(::geteuid()));
    ::mkdir(path.c_str(), 0700);
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != ::geteuid() ||
        (status.st_mode & 0077) != 0)
        return std::nullopt;
    return path;
}

}  // namespace afferent
