// The two formats of events in HDF5, and which of them a file is in.
#pragma once

#include <filesystem>
#include <optional>

namespace afferent {

enum class Hdf5Format {
    // *.sonata.h5: /spikes with a population for each patch: timestamps in ms and node_ids, by time; and
    // /nodes, which has the silent ones too (SONATA developer guide).
    sonata,
    // *.nwb: NWB 2's table /units: id, patch, spike_times in s and where each unit's end.
    nwb,
};

// By the ending of the name; nothing for any other ending.
inline std::optional<Hdf5Format> hdf5_format_of(const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    if (name.ends_with(".sonata.h5")) return Hdf5Format::sonata;
    if (name.ends_with(".nwb")) return Hdf5Format::nwb;
    return std::nullopt;
}

}  // namespace afferent
