#include "afferent/io/files/nwb_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "afferent/io/files/hdf5.hpp"
#include "afferent/io/files/hdf5_events.hpp"

namespace afferent {
namespace {

constexpr double ns_per_s = 1e9;

// ISO 8601 in UTC, to the millisecond.
std::string date(std::chrono::system_clock::time_point time) {
    using namespace std::chrono;
    const auto since = duration_cast<milliseconds>(time.time_since_epoch());
    const auto whole = floor<std::chrono::seconds>(since);
    const std::time_t t = whole.count();
    std::tm utc{};
    gmtime_r(&t, &utc);
    std::array<char, 64> text{};
    const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc);
    std::snprintf(text.data() + length, text.size() - length, ".%03dZ",
                  static_cast<int>((since - whole).count()));
    return text.data();
}

// UUIDs derived from the events and the name of the object, so that the same events give the same file.
class Names {
  public:
    explicit Names(std::span<const Event> events) {
        for (const Event& event : events) {
            mix(static_cast<std::uint64_t>(event.time.time_since_epoch().count()));
            mix(event.address);
        }
    }

    std::string of(std::string_view object) const {
        Names names = *this;
        for (const char c : object) names.mix(static_cast<unsigned char>(c));
        // UUID version 8 (custom) and the variant of RFC 9562.
        const std::uint64_t high = (names.a_ & ~0xf000ULL) | 0x8000ULL;
        const std::uint64_t low = (names.b_ & ~(3ULL << 62)) | (2ULL << 62);
        std::array<char, 40> text{};
        std::snprintf(text.data(), text.size(), "%08x-%04x-%04x-%04x-%012llx",
                      static_cast<unsigned>(high >> 32), static_cast<unsigned>(high >> 16 & 0xffff),
                      static_cast<unsigned>(high & 0xffff), static_cast<unsigned>(low >> 48),
                      static_cast<unsigned long long>(low & 0xffff'ffff'ffff));
        return text.data();
    }

  private:
    // FNV-1a with two beginnings, a word at a time.
    void mix(std::uint64_t word) noexcept {
        a_ = (a_ ^ word) * 0x100000001b3ULL;
        a_ ^= a_ >> 29;
        b_ = (b_ ^ word) * 0x100000001b3ULL;
        b_ ^= b_ >> 31;
    }
    std::uint64_t a_ = 0xcbf29ce484222325ULL;
    std::uint64_t b_ = 0x9e3779b97f4a7c15ULL;
};

bool describe(hid_t object, const char* space, const char* type, const std::string& id) {
    return hdf5::write_attribute(object, "namespace", std::string(space)) &&
           hdf5::write_attribute(object, "neurodata_type", std::string(type)) &&
           hdf5::write_attribute(object, "object_id", id);
}

bool make_group(hid_t file, const char* path) {
    return bool(hdf5::Group(H5Gcreate2(file, path, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)));
}

// The objects that the schema requires in every file (NWB 2.6.0, nwb.file).
bool write_session(hid_t file, const NwbSession& session, const Names& names) {
    for (const char* path : {"/acquisition", "/analysis", "/processing", "/stimulus",
                             "/stimulus/presentation", "/stimulus/templates", "/general"})
        if (!make_group(file, path)) return false;
    return describe(file, "core", "NWBFile", names.of("/")) &&
           hdf5::write_attribute(file, "nwb_version", std::string("2.6.0")) &&
           hdf5::write_text(file, "identifier", names.of("identifier")) &&
           hdf5::write_text(file, "session_description", session.description) &&
           hdf5::write_text(file, "session_start_time", date(session.start)) &&
           hdf5::write_text(file, "timestamps_reference_time", date(session.start)) &&
           bool(hdf5::write_column(file, "file_create_date", {date(session.created)}));
}

// The table of units: a row for each afferent, its spikes one after the other.
struct Units {
    std::vector<std::int64_t> id;
    std::vector<double> spike_times;
    std::vector<std::uint64_t> spike_times_index;  // the end of each unit's spikes
};

Units units_of(const EventSet& set) {
    std::vector<Event> by_address = set.events;
    std::stable_sort(by_address.begin(), by_address.end(),
                     [](const Event& a, const Event& b) { return a.address < b.address; });
    const bool all = !set.population.patches.empty();
    Units units;
    const auto add = [&](std::int64_t id) {
        units.id.push_back(id);
        units.spike_times_index.push_back(units.spike_times.size());
    };
    for (const Event& event : by_address) {
        while (all && units.id.size() <= event.address) add(static_cast<std::int64_t>(units.id.size()));
        if (!all && (units.id.empty() || units.id.back() != event.address)) add(event.address);
        units.spike_times.push_back(static_cast<double>((event.time - scene_start).count()) / ns_per_s);
        units.spike_times_index.back() = units.spike_times.size();
    }
    while (units.id.size() < set.population.size()) add(static_cast<std::int64_t>(units.id.size()));
    return units;
}

// The columns of the table that tell of a unit, each written as it is added.
class Columns {
  public:
    Columns(hid_t table, const Names& names) : table_(table), names_(names) {}

    template <class Values>
    void add(const char* name, const char* description, const Values& values) {
        const hdf5::Dataset column = hdf5::write_column(table_, name, values);
        written_ =
            written_ && column &&
            describe(column.id(), "hdmf-common", "VectorData", names_.of(std::string("/units/") + name)) &&
            hdf5::write_attribute(column.id(), "description", std::string(description));
        column_names_.emplace_back(name);
    }

    bool written() const noexcept { return written_; }
    const std::vector<std::string>& names() const noexcept { return column_names_; }

  private:
    hid_t table_;
    const Names& names_;
    bool written_ = true;
    std::vector<std::string> column_names_;
};

// What each afferent's patch says of it.
std::vector<std::string> for_each_afferent(const Population& population,
                                           std::string Population::Patch::*member) {
    std::vector<std::string> texts;
    texts.reserve(population.size());
    for (const Population::Patch& patch : population.patches)
        texts.insert(texts.end(), patch.afferents, patch.*member);
    return texts;
}

void add_population(Columns& columns, const Population& population) {
    if (population.patches.empty()) return;
    columns.add("patch", "The patch of skin that each unit belongs to",
                for_each_afferent(population, &Population::Patch::name));
    if (population.has_kinds())
        columns.add("kind", "The kind of afferent that each unit is",
                    for_each_afferent(population, &Population::Patch::kind));
    if (population.afferents.empty()) return;
    const auto column = [&](auto value_of) {
        std::vector<decltype(value_of(population.afferents[0]))> values;
        values.reserve(population.afferents.size());
        for (const Population::Afferent& each : population.afferents) values.push_back(value_of(each));
        return values;
    };
    if (population.has_positions()) {
        const Position nowhere{std::nan(""), std::nan("")};
        columns.add("x_mm", "Where each unit lies on the skin, in mm; NaN: its patch has no dimensions",
                    column([&](const Population::Afferent& of) { return of.place.value_or(nowhere).x_mm; }));
        columns.add("y_mm", "Where each unit lies on the skin, in mm; NaN: its patch has no dimensions",
                    column([&](const Population::Afferent& of) { return of.place.value_or(nowhere).y_mm; }));
    }
    columns.add("element", "The sensor element that each unit reads most",
                column([](const Population::Afferent& of) { return std::uint64_t{of.element}; }));
    columns.add("elements", "How many sensor elements each unit reads",
                column([](const Population::Afferent& of) { return std::uint64_t{of.elements}; }));
}

bool write_units(hid_t file, const EventSet& set, const Names& names) {
    const Units units = units_of(set);
    const hdf5::Group table(H5Gcreate2(file, "/units", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    if (!table) return false;
    Columns columns(table.id(), names);
    add_population(columns, set.population);
    columns.add("spike_times", "Of each unit, in seconds", units.spike_times);
    const hdf5::Dataset times(H5Dopen2(table.id(), "spike_times", H5P_DEFAULT));
    const hdf5::Dataset id = hdf5::write_column(table.id(), "id", units.id);
    const hdf5::Dataset index = hdf5::write_column(table.id(), "spike_times_index", units.spike_times_index);
    return columns.written() && id && times && index &&
           describe(table.id(), "core", "Units", names.of("/units")) &&
           hdf5::write_attribute(table.id(), "description", std::string("Afferents by address")) &&
           hdf5::write_attribute(table.id(), "colnames", columns.names()) &&
           describe(id.id(), "hdmf-common", "ElementIdentifiers", names.of("/units/id")) &&
           hdf5::write_attribute(times.id(), "resolution",
                                 static_cast<double>(set.resolution.count()) / ns_per_s) &&
           describe(index.id(), "hdmf-common", "VectorIndex", names.of("/units/spike_times_index")) &&
           hdf5::write_attribute(index.id(), "description", std::string("Where each unit's spikes end")) &&
           hdf5::write_reference(index.id(), "target", file, "/units/spike_times");
}

// The patches: runs of equal names. None if rows are not counted from 0, or one has no name.
std::vector<Population::Patch> patches_of(hid_t table, const std::vector<std::uint64_t>& ids) {
    const auto names = hdf5::read_texts(table, "patch");
    if (!names || names.value().size() != ids.size()) return {};
    const auto kinds = hdf5::read_texts(table, "kind");
    const bool has_kinds = kinds && kinds.value().size() == ids.size();
    std::vector<Population::Patch> patches;
    for (std::size_t row = 0; row < ids.size(); ++row) {
        const std::string& name = names.value()[row];
        if (ids[row] != row || name.empty()) return {};
        if (patches.empty() || patches.back().name != name)
            patches.push_back({name, 0, has_kinds ? kinds.value()[row] : ""});
        ++patches.back().afferents;
    }
    return patches;
}

Population population_of(hid_t table, const std::vector<std::uint64_t>& ids) {
    Population population{.patches = patches_of(table, ids)};
    if (!population.patches.empty())
        population.afferents = hdf5::read_afferents(table, {.x = "x_mm", .y = "y_mm"}, ids.size());
    return population;
}

Result<EventSet> read_units(hid_t table) {
    AFFERENT_TRY(ids, hdf5::read_whole_numbers(table, "id"));
    AFFERENT_TRY(times, hdf5::read_numbers(table, "spike_times"));
    AFFERENT_TRY(ends, hdf5::read_whole_numbers(table, "spike_times_index"));
    const auto malformed = [](const std::string& text) { return Error{Error::Kind::malformed, text}; };
    if (ends.size() != ids.size())
        return malformed("id and spike_times_index differ in their number of rows");
    if ((ends.empty() ? 0 : ends.back()) != times.size())
        return malformed("spike_times_index must end with the number of spike_times");
    EventSet set{.events = {}, .population = population_of(table, ids)};
    std::vector<Event>& events = set.events;
    for (std::size_t row = 0; row < ids.size(); ++row) {
        if (!hdf5::is_address(ids[row]))
            return malformed("id, row " + std::to_string(row) + ": must be below 2^32");
        if (ends[row] < events.size() || ends[row] > times.size())
            return malformed("spike_times_index, row " + std::to_string(row) + ": must not fall");
        while (events.size() < ends[row]) {
            Event event{scene_start, static_cast<Address>(ids[row])};
            if (!hdf5::read_time(times[events.size()], ns_per_s, event.time))
                return malformed("spike_times, row " + std::to_string(events.size()) +
                                 ": is not a time since the start");
            events.push_back(event);
        }
    }
    std::sort(events.begin(), events.end());
    const hdf5::Dataset spike_times(H5Dopen2(table, "spike_times", H5P_DEFAULT));
    set.resolution = hdf5::resolution(spike_times.id(), ns_per_s);
    return set;
}

}  // namespace

Result<void> write_nwb(const std::filesystem::path& file, const EventSet& set, const NwbSession& session) {
    AFFERENT_TRY(hdf5::check_set(set));
    const hdf5::Quiet quiet;
    const Names names(set.events);
    const hdf5::File out = hdf5::create_file("nwb");
    if (!out || !write_session(out.id(), session, names) || !write_units(out.id(), set, names) ||
        !hdf5::save(out, file))
        return hdf5::not_written();
    return success();
}

Result<EventSet> read_nwb(const std::filesystem::path& file) {
    const hdf5::Quiet quiet;
    AFFERENT_TRY(in, hdf5::open_file(file));
    if (hdf5::text_attribute(in.id(), "neurodata_type") != "NWBFile")
        return Error{Error::Kind::malformed, "the file is not of NWB 2"};
    AFFERENT_TRY(units, hdf5::open_group(in.id(), "units"));
    return read_units(units.id());
}

}  // namespace afferent
