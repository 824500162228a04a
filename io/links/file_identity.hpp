// Identifies a file whatever its name.
#pragma once

#include <sys/stat.h>

#include <optional>
#include <string>

namespace afferent {

struct FileIdentity {
    dev_t device = 0;
    ino_t inode = 0;

    friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};

inline FileIdentity identity_of(const struct stat& status) { return {status.st_dev, status.st_ino}; }

// The identity of the file that has this name now; of a symbolic link that of the link itself.
inline std::optional<FileIdentity> identity_at(const std::string& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) return std::nullopt;
    return identity_of(status);
}

}  // namespace afferent
