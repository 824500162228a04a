#include "afferent/io/files/sonata_file.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include "afferent/io/files/hdf5.hpp"
#include "afferent/io/files/hdf5_events.hpp"

namespace afferent {
namespace {

constexpr double ns_per_ms = 1e6;
constexpr std::array<std::uint32_t, 1> magic{0x0a7a};
constexpr std::array<std::uint32_t, 2> version{0, 1};

// An enumeration, as in the developer guide.
bool write_sorting(hid_t object) {
    const hdf5::Type type(H5Tenum_create(H5T_STD_U8LE));
    for (std::uint8_t value = 0; const char* name : {"none", "by_id", "by_time"}) {
        if (H5Tenum_insert(type.id(), name, &value) < 0) return false;
        ++value;
    }
    const std::uint8_t by_time = 2;
    const hdf5::Space scalar(H5Screate(H5S_SCALAR));
    const hdf5::Attribute attribute(
        H5Acreate2(object, "sorting", type.id(), scalar.id(), H5P_DEFAULT, H5P_DEFAULT));
    return attribute && H5Awrite(attribute.id(), type.id(), &by_time) >= 0;
}

hdf5::Group add_group(hid_t parent, const std::string& name) {
    return hdf5::Group(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
}

// Events of consecutive addresses, whose nodes count from 0.
struct Population {
    std::string name = "afferent";
    std::uint32_t first = 0;
    std::optional<std::uint32_t> nodes = {};  // not known: no more than that these have fired
};

bool write_spikes(hid_t spikes, const EventSet& set, const Population& population) {
    std::vector<double> timestamps;
    std::vector<std::uint64_t> node_ids;
    for (const Event& event : set.events) {
        if (event.address < population.first ||
            (population.nodes && event.address - population.first >= *population.nodes))
            continue;
        timestamps.push_back(static_cast<double>((event.time - scene_start).count()) / ns_per_ms);
        node_ids.push_back(event.address - population.first);
    }
    const hdf5::Group group = add_group(spikes, population.name);
    const std::array first{population.first};
    if (!group || !write_sorting(group.id()) ||
        !hdf5::write_attribute(group.id(), "first_address", first, true))
        return false;
    const hdf5::Dataset times = hdf5::write_column(group.id(), "timestamps", timestamps);
    return times && hdf5::write_attribute(times.id(), "units", std::string("ms")) &&
           hdf5::write_attribute(times.id(), "resolution",
                                 static_cast<double>(set.resolution.count()) / ns_per_ms) &&
           hdf5::write_column(group.id(), "node_ids", node_ids);
}

// All of one type, without attributes of their own.
bool write_nodes(hid_t nodes, const Population& population) {
    const hdf5::Group group = add_group(nodes, population.name);
    std::vector<std::uint64_t> ids(*population.nodes);
    std::iota(ids.begin(), ids.end(), std::uint64_t{0});
    const std::vector<std::uint64_t> zeros(ids.size(), 0);
    return group && add_group(group.id(), "0") && hdf5::write_column(group.id(), "node_id", ids) &&
           hdf5::write_column(group.id(), "node_type_id", zeros) &&
           hdf5::write_column(group.id(), "node_group_id", zeros) &&
           hdf5::write_column(group.id(), "node_group_index", ids);
}

std::vector<Population> populations_of(const EventSet& set) {
    if (set.patches.empty()) return {Population()};
    std::vector<Population> populations;
    std::uint32_t first = 0;
    for (const EventSet::Patch& patch : set.patches) {
        populations.push_back({patch.name, first, patch.afferents});
        first += patch.afferents;
    }
    return populations;
}

Error malformed(const std::string& text) { return {Error::Kind::malformed, text}; }

// Adds its events to the set.
Result<void> read_population(hid_t population, std::uint64_t first, EventSet& set) {
    AFFERENT_TRY(times, hdf5::read_numbers(population, "timestamps"));
    AFFERENT_TRY(ids, hdf5::read_whole_numbers(population, "node_ids"));
    if (times.size() != ids.size())
        return malformed("timestamps and node_ids differ in their number of rows");
    const hdf5::Dataset timestamps(H5Dopen2(population, "timestamps", H5P_DEFAULT));
    const std::string units = hdf5::text_attribute(timestamps.id(), "units");
    if (!units.empty() && units != "ms") return malformed("timestamps must be in ms, are in something else");
    set.resolution = hdf5::resolution(timestamps.id(), ns_per_ms);
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const std::string row = ", row " + std::to_string(i);
        if (!hdf5::is_address(ids[i]) || !hdf5::is_address(first + ids[i]))
            return malformed("node_ids" + row + ": must be below 2^32");
        Event event{scene_start, static_cast<Address>(first + ids[i])};
        if (!hdf5::read_time(times[i], ns_per_ms, event.time))
            return malformed("timestamps" + row + ": is not a time since the start");
        set.events.push_back(event);
    }
    return success();
}

// How many nodes a population has, if the file tells.
std::optional<std::uint32_t> nodes_of(hid_t file, const std::string& name) {
    const auto nodes = hdf5::open_group(file, "nodes");
    if (!nodes) return std::nullopt;
    const auto group = hdf5::open_group(nodes.value().id(), name);
    if (!group) return std::nullopt;
    const auto types = hdf5::read_whole_numbers(group.value().id(), "node_type_id");
    return types ? std::optional(static_cast<std::uint32_t>(types.value().size())) : std::nullopt;
}

// The patches, if the populations follow each other from address 0 on.
std::vector<EventSet::Patch> patches_of(std::vector<Population> populations) {
    std::sort(populations.begin(), populations.end(),
              [](const Population& a, const Population& b) { return a.first < b.first; });
    std::vector<EventSet::Patch> patches;
    std::uint64_t next = 0;
    for (const Population& population : populations) {
        if (!population.nodes || population.first != next) return {};
        patches.push_back({population.name, *population.nodes});
        next += *population.nodes;
    }
    return patches;
}

}  // namespace

Result<void> write_sonata(const std::filesystem::path& file, const EventSet& set) {
    AFFERENT_TRY(hdf5::check_set(set));
    for (const EventSet::Patch& patch : set.patches)
        if (patch.name.find('/') != std::string::npos)
            return Error{Error::Kind::not_allowed, file.string() + ": the name of patch \"" + patch.name +
                                                       "\" has a slash, which a population's cannot have"};
    const hdf5::Quiet quiet;
    const hdf5::File out = hdf5::create_file();
    const hdf5::Group spikes = add_group(out.id(), "spikes");
    bool written = spikes && hdf5::write_attribute(out.id(), "magic", magic, true) &&
                   hdf5::write_attribute(out.id(), "version", version, false);
    const hdf5::Group nodes = set.patches.empty() ? hdf5::Group() : add_group(out.id(), "nodes");
    for (const Population& population : populations_of(set))
        written = written && write_spikes(spikes.id(), set, population) &&
                  (!population.nodes || write_nodes(nodes.id(), population));
    if (!written || !hdf5::save(out, file)) return hdf5::not_written();
    return success();
}

Result<EventSet> read_sonata(const std::filesystem::path& file) {
    constexpr std::size_t most_populations = 1000;
    const hdf5::Quiet quiet;
    AFFERENT_TRY(in, hdf5::open_file(file));
    AFFERENT_TRY(spikes, hdf5::open_group(in.id(), "spikes"));
    const auto names = hdf5::groups_in(spikes.id(), most_populations);
    if (!names || names.value().empty()) return malformed("spikes must have a population");
    EventSet set;
    std::vector<Population> populations;
    for (const std::string& name : names.value()) {
        AFFERENT_TRY(group, hdf5::open_group(spikes.id(), name));
        const auto first = hdf5::number_attribute(group.id(), "first_address");
        if ((!first && names.value().size() > 1) || (first && !(*first >= 0 && *first < 4294967296.0)))
            return malformed("spikes has several populations, and population \"" + name +
                             "\" has no attribute first_address, which tells their addresses apart. Convert "
                             "them one by one");
        populations.push_back({name, static_cast<std::uint32_t>(first.value_or(0)), nodes_of(in.id(), name)});
        AFFERENT_TRY(read_population(group.id(), populations.back().first, set));
    }
    std::sort(set.events.begin(), set.events.end());
    set.patches = patches_of(std::move(populations));
    if (!check(set)) set.patches.clear();
    return set;
}

}  // namespace afferent
