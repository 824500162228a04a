// Recorded input, which a test goes without where it is absent.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace afferent {

// The folder beside the project's, unless the environment names another.
inline std::filesystem::path shared_data() {
    const char* const named = std::getenv("AFFERENT_SHARED_DATA");
    return named ? named : AFFERENT_SOURCE_DIR "/../shared/data";
}

}  // namespace afferent
