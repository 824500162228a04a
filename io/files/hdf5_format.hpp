// The two formats of events in HDF5, and which of them a file is in.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace afferent {

enum class Hdf5Format {
    // *.sonata.h5: /spikes with a population for each patch: timestamps in ms and node_ids, by time. Beside
    // it
    // *.nodes.h5, which has the silent ones too, and *.node_types.csv (SONATA developer guide).
    sonata,
    // *.nwb: NWB 2's table /units: id, patch, kind, place, spike_times in s and where each unit's end.
    nwb,
};

// By the ending of the name; nothing for any other ending.
inline std::optional<Hdf5Format> hdf5_format_of(const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    if (name.ends_with(".sonata.h5")) return Hdf5Format::sonata;
    if (name.ends_with(".nwb")) return Hdf5Format::nwb;
    return std::nullopt;
}

// The other files of "x.sonata.h5": "x.nodes.h5" and "x.node_types.csv".
inline std::filesystem::path beside_sonata(const std::filesystem::path& file, const char* ending) {
    constexpr std::string_view own = ".sonata.h5";
    std::string name = file.string();
    if (name.ends_with(own)) name.resize(name.size() - own.size());
    return name + ending;
}
inline std::filesystem::path sonata_nodes(const std::filesystem::path& file) {
    return beside_sonata(file, ".nodes.h5");
}
inline std::filesystem::path sonata_node_types(const std::filesystem::path& file) {
    return beside_sonata(file, ".node_types.csv");
}

}  // namespace afferent
