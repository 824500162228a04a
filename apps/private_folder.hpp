// Where a program keeps what other processes of the same user may find, and nobody else.
#pragma once

#include <filesystem>
#include <optional>

namespace afferent {

// A folder that only this user can enter: in XDG_RUNTIME_DIR, or beside other temporary files. Made if it is
// absent; nothing if that fails, or if the folder is open to others.
std::optional<std::filesystem::path> private_folder();

}  // namespace afferent
