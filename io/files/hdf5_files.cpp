#include "afferent/io/files/hdf5_files.hpp"

#include <string>

namespace afferent {

std::optional<Hdf5Format> hdf5_format_of(const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    if (name.ends_with(".sonata.h5")) return Hdf5Format::sonata;
    if (name.ends_with(".nwb")) return Hdf5Format::nwb;
    return std::nullopt;
}

}  // namespace afferent
