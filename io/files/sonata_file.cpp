#include "afferent/io/files/sonata_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <optional>

#include "afferent/io/files/hdf5.hpp"
#include "afferent/io/files/hdf5_events.hpp"

namespace afferent {
namespace {

constexpr double ns_per_ms = 1e6;
constexpr double um_per_mm = 1e3;
constexpr std::array<std::uint32_t, 1> magic{0x0a7a};
constexpr std::array<std::uint32_t, 2> version{0, 1};

bool write_format(hid_t file) {
    return hdf5::write_attribute(file, "magic", magic, true) &&
           hdf5::write_attribute(file, "version", version, false);
}

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
struct Spiking {
    std::string name = "afferent";
    std::uint32_t first = 0;
    std::optional<std::uint32_t> nodes = {};  // not known: no more than that these have fired
    std::string kind = {};
    std::vector<Population::Afferent> afferents = {};
};

bool write_spikes(hid_t spikes, const EventSet& set, const Spiking& population) {
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

bool write_length(hid_t group, const char* name, const std::vector<double>& um) {
    const hdf5::Dataset column = hdf5::write_column(group, name, um);
    return column && hdf5::write_attribute(column.id(), "units", std::string("um"));
}

// What the afferents have of their own.
bool write_node_group(hid_t group, const std::vector<Population::Afferent>& afferents) {
    if (afferents.empty()) return true;
    std::vector<std::uint64_t> element;
    std::vector<std::uint64_t> elements;
    std::vector<double> x_um;
    std::vector<double> y_um;
    for (const Population::Afferent& each : afferents) {
        element.push_back(each.element);
        elements.push_back(each.elements);
        const Position place = each.place.value_or(Position{std::nan(""), std::nan("")});
        x_um.push_back(place.x_mm * um_per_mm);
        y_um.push_back(place.y_mm * um_per_mm);
    }
    if (!hdf5::write_column(group, "element", element) || !hdf5::write_column(group, "elements", elements))
        return false;
    const bool has_positions =
        std::ranges::any_of(afferents, [](const auto& of) { return of.place.has_value(); });
    return !has_positions || (write_length(group, "x", x_um) && write_length(group, "y", y_um) &&
                              write_length(group, "z", std::vector<double>(x_um.size(), 0)));
}

// All of one type, and in one group.
bool write_nodes(hid_t nodes, const Spiking& population, std::uint64_t type) {
    const hdf5::Group group = add_group(nodes, population.name);
    const hdf5::Group attributes = group ? add_group(group.id(), "0") : hdf5::Group();
    std::vector<std::uint64_t> ids(*population.nodes);
    std::iota(ids.begin(), ids.end(), std::uint64_t{0});
    return attributes && write_node_group(attributes.id(), population.afferents) &&
           (population.kind.empty() || hdf5::write_attribute(group.id(), "kind", population.kind)) &&
           hdf5::write_column(group.id(), "node_id", ids) &&
           hdf5::write_column(group.id(), "node_type_id", std::vector(ids.size(), type)) &&
           hdf5::write_column(group.id(), "node_group_id", std::vector(ids.size(), std::uint64_t{0})) &&
           hdf5::write_column(group.id(), "node_group_index", ids);
}

// A text in a table whose columns are separated by spaces.
std::string quoted(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

std::string node_types(const std::vector<Spiking>& populations) {
    std::string table = "node_type_id population model_type model_template kind\n";
    for (std::size_t type = 0; type < populations.size(); ++type) {
        const auto& [name, first, nodes, kind, afferents] = populations[type];
        table += std::to_string(type) + ' ' + quoted(name) + " virtual NULL " +
                 (kind.empty() ? "NULL" : quoted(kind)) + '\n';
    }
    return table;
}

// Nodes and their types, in files beside that of the spikes.
bool write_nodes_beside(const std::filesystem::path& file, const std::vector<Spiking>& populations) {
    const hdf5::File out = hdf5::create_file("nodes");
    const hdf5::Group nodes = add_group(out.id(), "nodes");
    bool written = nodes && write_format(out.id());
    for (std::size_t type = 0; type < populations.size(); ++type)
        written = written && write_nodes(nodes.id(), populations[type], type);
    if (!written || !hdf5::save(out, sonata_nodes(file))) return false;
    std::ofstream types(sonata_node_types(file), std::ios::binary);
    types << node_types(populations);
    types.close();
    return bool(types);
}

std::vector<Spiking> populations_of(const EventSet& set) {
    const Population& all = set.population;
    if (all.patches.empty()) return {Spiking()};
    std::vector<Spiking> populations;
    std::uint32_t first = 0;
    for (const Population::Patch& patch : all.patches) {
        populations.push_back({patch.name, first, patch.afferents, patch.kind});
        if (!all.afferents.empty())
            populations.back().afferents.assign(all.afferents.begin() + first,
                                                all.afferents.begin() + first + patch.afferents);
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

// Adds what the file's nodes tell of the population, if it has any.
void read_nodes(hid_t file, Spiking& population) {
    const auto nodes = hdf5::open_group(file, "nodes");
    if (!nodes) return;
    const auto group = hdf5::open_group(nodes.value().id(), population.name);
    if (!group) return;
    const auto types = hdf5::read_whole_numbers(group.value().id(), "node_type_id");
    if (!types) return;
    population.nodes = static_cast<std::uint32_t>(types.value().size());
    population.kind = hdf5::text_attribute(group.value().id(), "kind");
    if (const auto attributes = hdf5::open_group(group.value().id(), "0"))
        population.afferents = hdf5::read_afferents(
            attributes.value().id(), {.x = "x", .y = "y", .units_per_mm = um_per_mm}, *population.nodes);
}

// Who they are, if the populations follow each other from address 0 on.
Population population_of(std::vector<Spiking> populations) {
    std::sort(populations.begin(), populations.end(),
              [](const Spiking& a, const Spiking& b) { return a.first < b.first; });
    Population all;
    for (const Spiking& each : populations) {
        if (!each.nodes || each.first != all.size()) return {};
        all.patches.push_back({each.name, *each.nodes, each.kind});
        all.afferents.insert(all.afferents.end(), each.afferents.begin(), each.afferents.end());
    }
    if (all.afferents.size() != all.size()) all.afferents.clear();
    return all;
}

}  // namespace

Result<void> write_sonata(const std::filesystem::path& file, const EventSet& set) {
    AFFERENT_TRY(hdf5::check_set(set));
    const std::vector<Spiking> populations = populations_of(set);
    for (const Spiking& population : populations)
        if (population.name.find('/') != std::string::npos)
            return Error{Error::Kind::not_allowed, file.string() + ": the name of patch \"" +
                                                       population.name +
                                                       "\" has a slash, which a population's cannot have"};
    const hdf5::Quiet quiet;
    const hdf5::File out = hdf5::create_file("spikes");
    const hdf5::Group spikes = add_group(out.id(), "spikes");
    bool written = spikes && write_format(out.id());
    for (const Spiking& population : populations)
        written = written && write_spikes(spikes.id(), set, population);
    written = written && hdf5::save(out, file);
    if (!set.population.patches.empty()) {
        written = written && write_nodes_beside(file, populations);
    } else if (written) {
        // Nodes of other spikes, whose place these take, are not theirs.
        for (const std::filesystem::path& beside : {sonata_nodes(file), sonata_node_types(file)}) {
            std::error_code ignored;
            std::filesystem::remove(beside, ignored);
        }
    }
    if (!written) return hdf5::not_written();
    return success();
}

Result<EventSet> read_sonata(const std::filesystem::path& file) {
    constexpr std::size_t most_populations = 1000;
    const hdf5::Quiet quiet;
    AFFERENT_TRY(in, hdf5::open_file(file));
    AFFERENT_TRY(spikes, hdf5::open_group(in.id(), "spikes"));
    const auto beside = hdf5::open_file(sonata_nodes(file));
    const auto names = hdf5::groups_in(spikes.id(), most_populations);
    if (!names || names.value().empty()) return malformed("spikes must have a population");
    EventSet set;
    std::vector<Spiking> populations;
    for (const std::string& name : names.value()) {
        AFFERENT_TRY(group, hdf5::open_group(spikes.id(), name));
        const auto first = hdf5::number_attribute(group.id(), "first_address");
        if ((!first && names.value().size() > 1) || (first && !(*first >= 0 && *first < 4294967296.0)))
            return malformed("spikes has several populations, and population \"" + name +
                             "\" has no attribute first_address, which tells their addresses apart. Convert "
                             "them one by one");
        Spiking& population = populations.emplace_back();
        population.name = name;
        population.first = static_cast<std::uint32_t>(first.value_or(0));
        read_nodes(beside ? beside.value().id() : in.id(), population);
        AFFERENT_TRY(read_population(group.id(), population.first, set));
    }
    std::sort(set.events.begin(), set.events.end());
    set.population = population_of(std::move(populations));
    if (!check(set)) set.population = {};
    return set;
}

}  // namespace afferent
