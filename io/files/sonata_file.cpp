#include "afferent/io/files/sonata_file.hpp"

#include <algorithm>
#include <array>

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

Result<std::vector<Event>> read_population(hid_t population) {
    AFFERENT_TRY(times, hdf5::read_numbers(population, "timestamps"));
    AFFERENT_TRY(ids, hdf5::read_whole_numbers(population, "node_ids"));
    const auto malformed = [](const std::string& text) { return Error{Error::Kind::malformed, text}; };
    if (times.size() != ids.size())
        return malformed("timestamps and node_ids differ in their number of rows");
    const hdf5::Dataset timestamps(H5Dopen2(population, "timestamps", H5P_DEFAULT));
    const std::string units = hdf5::text_attribute(timestamps.id(), "units");
    if (!units.empty() && units != "ms") return malformed("timestamps must be in ms, are in something else");
    std::vector<Event> events(ids.size());
    for (std::size_t i = 0; i < events.size(); ++i) {
        const std::string row = ", row " + std::to_string(i);
        if (!hdf5::is_address(ids[i])) return malformed("node_ids" + row + ": must be below 2^32");
        events[i].address = static_cast<Address>(ids[i]);
        if (!hdf5::read_time(times[i], ns_per_ms, events[i].time))
            return malformed("timestamps" + row + ": is not a time since the start");
    }
    std::sort(events.begin(), events.end());
    return events;
}

}  // namespace

Result<void> write_sonata(const std::filesystem::path& file, std::span<const Event> events) {
    AFFERENT_TRY(hdf5::check_times(events));
    const hdf5::Quiet quiet;
    std::vector<double> timestamps(events.size());
    std::vector<std::uint64_t> node_ids(events.size());
    for (std::size_t i = 0; i < events.size(); ++i) {
        timestamps[i] = static_cast<double>((events[i].time - scene_start).count()) / ns_per_ms;
        node_ids[i] = events[i].address;
    }
    const hdf5::File out = hdf5::create_file();
    const hdf5::Group spikes(H5Gcreate2(out.id(), "spikes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    const hdf5::Group population(H5Gcreate2(spikes.id(), "afferent", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    if (!population || !hdf5::write_attribute(out.id(), "magic", magic, true) ||
        !hdf5::write_attribute(out.id(), "version", version, false) || !write_sorting(population.id()))
        return hdf5::not_written(file);
    const hdf5::Dataset times = hdf5::write_column(population.id(), "timestamps", timestamps);
    if (!times || !hdf5::write_attribute(times.id(), "units", std::string("ms")) ||
        !hdf5::write_column(population.id(), "node_ids", node_ids) || !hdf5::save(out, file))
        return hdf5::not_written(file);
    return success();
}

Result<std::vector<Event>> read_sonata(const std::filesystem::path& file) {
    const hdf5::Quiet quiet;
    AFFERENT_TRY(in, hdf5::open_file(file));
    AFFERENT_TRY(spikes, hdf5::open_group(in.id(), "spikes"));
    const auto names = hdf5::groups_in(spikes.id(), 1);
    if (!names || names.value().size() != 1)
        return Error{Error::Kind::malformed, "spikes must have exactly one population"};
    AFFERENT_TRY(population, hdf5::open_group(spikes.id(), names.value().front()));
    return read_population(population.id());
}

}  // namespace afferent
