#include "afferent/io/files/hdf5_files.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "afferent/io/files/hdf5.hpp"
#include "tests/since_start.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

std::vector<Event> some_events(std::size_t count, Duration longest) {
    std::mt19937_64 random(1);
    std::vector<Event> events(count);
    for (Event& event : events)
        event = {
            at(Duration(static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(longest.count())))),
            static_cast<Address>(random() % 2 == 0 ? random() : random() % 9)};
    if (!events.empty()) events.push_back(events.back());
    std::sort(events.begin(), events.end());
    return events;
}

const NwbSession session{.start = std::chrono::system_clock::time_point(1'500'000'000'123ms), .created = {}};

struct Layout {
    const char* name;
    Result<void> (*write)(const fs::path&, const EventSet&);
    Result<EventSet> (*read)(const fs::path&);
};
const Layout layouts[] = {
    {"sonata.h5", write_sonata, read_sonata},
    {"nwb", [](const fs::path& file, const EventSet& set) { return write_nwb(file, set, session); },
     read_nwb}};

class Hdf5Files : public testing::TestWithParam<Layout> {
  protected:
    Hdf5Files()
        : file_(fs::temp_directory_path() /
                ("afferent-" + std::to_string(getpid()) + "." + GetParam().name)) {}
    ~Hdf5Files() override {
        for (const fs::path& file : {file_, sonata_nodes(file_), sonata_node_types(file_)}) fs::remove(file);
    }

    std::string refusal() const {
        const auto read = GetParam().read(file_);
        return read ? "accepted" : read.error().text;
    }

    fs::path file_;
};

TEST_P(Hdf5Files, ReadBackEqual) {
    for (const std::size_t count : {0, 1, 3000, 200'000}) {
        const auto events = some_events(count, 10s);
        const auto written = GetParam().write(file_, EventSet{.events = events});
        ASSERT_TRUE(written) << written.error().text;
        const auto read = GetParam().read(file_);
        ASSERT_TRUE(read) << read.error().text;
        EXPECT_EQ(read.value(), EventSet{.events = events});
    }
}

// Who has three patches: one with places, one without, and one of which only some afferents have one.
EventSet of_a_population() {
    return {.events = {{at(100us), 1}, {at(300us), 4}, {at(500us), 1}},
            .population = {.patches = {{"thumb", 2, "SA1"},
                                       {"index, \"left\"", 1, "sustained"},
                                       {"palm", 3, "PC"}},
                           // Eighths of a millimetre are exact in micrometres, too.
                           .afferents = {{.place = Position{1.5, -2.125}, .element = 0, .elements = 30},
                                         {.place = Position{0, 0.375}, .element = 9, .elements = 31},
                                         {.element = 12},
                                         {.place = Position{7, 8}, .element = 13, .elements = 4},
                                         {.element = 14, .elements = 2},
                                         {.place = Position{-7, 8}, .element = 17, .elements = 3}}},
            .resolution = 250us};
}

// Silence is a measurement: an afferent that has not fired has a unit without spikes.
TEST_P(Hdf5Files, KeepPatchesSilentAfferentsAndTick) {
    const EventSet set{.events = {{at(100us), 1}, {at(300us), 4}, {at(500us), 1}},
                       .population = {.patches = {{"thumb", 3}, {"index", 2}, {"palm", 70}}},
                       .resolution = 100us};
    ASSERT_TRUE(GetParam().write(file_, set));
    const auto read = GetParam().read(file_);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(read.value(), set);
    EventSet silent = set;
    silent.events.clear();
    ASSERT_TRUE(GetParam().write(file_, silent));
    EXPECT_EQ(value_or_throw(GetParam().read(file_)), silent);
    EventSet wrong = set;
    wrong.events.push_back({at(1s), 75});
    const auto refused = GetParam().write(file_, wrong);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().text, "an event has address 75, and the patches have 75 afferents");
}

TEST_P(Hdf5Files, KeepWhatIsKnownOfEachAfferent) {
    const EventSet set = of_a_population();
    const auto written = GetParam().write(file_, set);
    ASSERT_TRUE(written) << written.error().text;
    const auto read = GetParam().read(file_);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(read.value(), set);
    EventSet nowhere = set;
    for (Population::Afferent& each : nowhere.population.afferents) each.place.reset();
    ASSERT_TRUE(GetParam().write(file_, nowhere));
    EXPECT_EQ(value_or_throw(GetParam().read(file_)), nowhere);
}

// The last nanoseconds that a double of seconds or milliseconds tells apart for sure.
TEST_P(Hdf5Files, KeepNanosecondsUpToTheirLimitAndRefuseWhatIsBeyond) {
    std::vector<Event> events = some_events(100'000, longest_in_hdf5);
    for (int i = 20'000; i > 0; --i) events.push_back({at(longest_in_hdf5 - Duration(i)), 1});
    std::sort(events.begin(), events.end());
    ASSERT_TRUE(GetParam().write(file_, EventSet{.events = events}));
    EXPECT_EQ(value_or_throw(GetParam().read(file_)).events, events);
    const Result<void> refused = GetParam().write(file_, {.events = {{at(longest_in_hdf5), 1}}});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text.find("26 days"), std::string::npos);
}

TEST_P(Hdf5Files, AreRefusedWhereTheyAreCut) {
    ASSERT_TRUE(GetParam().write(file_, {.events = some_events(2000, 1s)}));
    for (auto size = fs::file_size(file_) - 1; size > 0; size = size * 9 / 10) {
        fs::resize_file(file_, size);
        EXPECT_EQ(refusal(), "the file is not an HDF5 file, or is cut off");
    }
    EXPECT_FALSE(GetParam().read("/nowhere/at/all"));
}

TEST_P(Hdf5Files, SayThatTheyCannotBeWritten) {
    const Result<void> written = GetParam().write("/nowhere/at/all", {.events = some_events(10, 1s)});
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().text, "cannot be written");
    EXPECT_TRUE(!fs::exists("/dev/full") || !GetParam().write("/dev/full", {.events = some_events(10, 1s)}));
}

INSTANTIATE_TEST_SUITE_P(Hdf5Files, Hdf5Files, testing::ValuesIn(layouts),
                         [](const auto& layout) { return layout.param.read == read_nwb ? "nwb" : "sonata"; });

TEST(Hdf5Files, AreKnownByTheirEndings) {
    EXPECT_EQ(hdf5_format_of("a/b.sonata.h5"), Hdf5Format::sonata);
    EXPECT_EQ(hdf5_format_of("b.nwb"), Hdf5Format::nwb);
    EXPECT_EQ(hdf5_format_of("b.h5"), std::nullopt);
}

// A spikes file that was moved without its nodes still has its events.
TEST(SonataFile, WithoutItsNodesTellsOnlyItsEvents) {
    const fs::path folder = fs::temp_directory_path() / ("afferent-sonata-" + std::to_string(getpid()));
    fs::create_directory(folder);
    const fs::path file = folder / "a.sonata.h5";
    const EventSet set = of_a_population();
    ASSERT_TRUE(write_sonata(file, set));
    EXPECT_TRUE(fs::exists(folder / "a.nodes.h5"));
    fs::remove(folder / "a.nodes.h5");
    const auto read = read_sonata(file);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(read.value().events, set.events);
    EXPECT_EQ(read.value().population, Population());
    std::ifstream types(folder / "a.node_types.csv");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(types), {}),
              "node_type_id population model_type model_template kind\n"
              "0 \"thumb\" virtual NULL \"SA1\"\n"
              "1 \"index, \"\"left\"\"\" virtual NULL \"sustained\"\n"
              "2 \"palm\" virtual NULL \"PC\"\n");
    fs::remove_all(folder);
}

// Files that other programs could have written, each wrong in one way.
class StrangeHdf5 : public testing::Test {
  protected:
    StrangeHdf5()
        : file_(fs::temp_directory_path() / ("afferent-strange-" + std::to_string(getpid()) + ".h5")) {}
    ~StrangeHdf5() override { fs::remove(file_); }

    // A SONATA file whose columns the caller makes.
    template <class Fill>
    std::string refusal(const Fill& fill) {
        const hdf5::Quiet quiet;
        {
            const hdf5::File out(H5Fcreate(file_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
            const hdf5::Group spikes(H5Gcreate2(out.id(), "spikes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
            const hdf5::Group population(H5Gcreate2(spikes.id(), "p", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
            fill(population.id());
        }
        const auto read = read_sonata(file_);
        return read ? "accepted" : read.error().text;
    }

    static constexpr double times[] = {1.5, 0.25};
    static constexpr std::uint64_t ids[] = {7, 3};
    fs::path file_;
};

TEST_F(StrangeHdf5, IsReadWhereItIsOnlyUnsorted) {
    EXPECT_EQ(refusal([](hid_t group) {
                  hdf5::write_column(group, "timestamps", times);
                  hdf5::write_column(group, "node_ids", ids);
              }),
              "accepted");
    EXPECT_EQ(value_or_throw(read_sonata(file_)).events,
              (std::vector<Event>{{at(250us), 3}, {at(1500us), 7}}));
}

TEST_F(StrangeHdf5, IsRefusedWithTheReason) {
    EXPECT_EQ(refusal([](hid_t) {}), "timestamps is missing");
    EXPECT_EQ(refusal([](hid_t group) { hdf5::write_column(group, "timestamps", times); }),
              "node_ids is missing");
    EXPECT_EQ(refusal([](hid_t group) { hdf5::write_column(group, "timestamps", ids); }),
              "timestamps must be of floating point");
    EXPECT_EQ(refusal([](hid_t group) { hdf5::write_text(group, "timestamps", "soon"); }),
              "timestamps must be of floating point");
    EXPECT_EQ(refusal([](hid_t group) {
                  hdf5::write_column(group, "timestamps", std::span(times).first(1));
                  hdf5::write_column(group, "node_ids", ids);
              }),
              "timestamps and node_ids differ in their number of rows");
    EXPECT_EQ(refusal([](hid_t group) {
                  const double wrong[] = {1.5, std::nan("")};
                  hdf5::write_column(group, "timestamps", wrong);
                  hdf5::write_column(group, "node_ids", ids);
              }),
              "timestamps, row 1: is not a time since the start");
    EXPECT_EQ(refusal([](hid_t group) {
                  const std::uint64_t wrong[] = {7, std::uint64_t{1} << 32};
                  hdf5::write_column(group, "timestamps", times);
                  hdf5::write_column(group, "node_ids", wrong);
              }),
              "node_ids, row 1: must be below 2^32");
    EXPECT_EQ(refusal([](hid_t group) {
                  const std::int64_t wrong[] = {7, -1};
                  hdf5::write_column(group, "timestamps", times);
                  hdf5::write_column(group, "node_ids", wrong);
              }),
              "node_ids has a negative number");
    EXPECT_EQ(refusal([](hid_t group) {
                  const auto column = hdf5::write_column(group, "timestamps", times);
                  hdf5::write_attribute(column.id(), "units", std::string("h"));
                  hdf5::write_column(group, "node_ids", ids);
              }),
              "timestamps must be in ms, are in something else");
    EXPECT_EQ(refusal([](hid_t group) {
                  H5Lcreate_external("/etc/passwd", "/a", group, "timestamps", H5P_DEFAULT, H5P_DEFAULT);
              }),
              "timestamps is missing");
}

// A chunk that was never written takes no room, whatever the file claims.
TEST_F(StrangeHdf5, IsRefusedWhereItClaimsMoreThanItHolds) {
    for (const hsize_t rows : {hsize_t{1} << 24, hsize_t{1} << 60}) {
        const std::string said = refusal([rows](hid_t group) {
            const hsize_t chunk = 1024;
            const hdf5::Space space(H5Screate_simple(1, &rows, nullptr));
            const hdf5::Properties properties(H5Pcreate(H5P_DATASET_CREATE));
            H5Pset_chunk(properties.id(), 1, &chunk);
            H5Pset_deflate(properties.id(), 9);
            const hdf5::Dataset claimed(H5Dcreate2(group, "timestamps", H5T_IEEE_F64LE, space.id(),
                                                   H5P_DEFAULT, properties.id(), H5P_DEFAULT));
        });
        EXPECT_TRUE(said == "timestamps claims more rows than the file holds" ||
                    said == "timestamps has more than 2^28 rows")
            << said;
    }
}

TEST_F(StrangeHdf5, OfTwoPopulationsIsRefused) {
    EXPECT_EQ(
        refusal([](hid_t group) {
            const hdf5::Group more(H5Gcreate2(group, "/spikes/q", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        }),
        "spikes has several populations, and population \"p\" has no attribute first_address, which tells "
        "their addresses apart. Convert them one by one");
}

// As another program would see it.
TEST(NwbFile, IsWhatTheSchemaAsks) {
    const fs::path file = fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + "-s.nwb");
    ASSERT_TRUE(write_nwb(file, {.events = {{at(1s), 4}, {at(2s), 2}, {at(3s), 4}}}, session));
    const auto in = hdf5::open_file(file);
    ASSERT_TRUE(in);
    for (const char* group : {"acquisition", "analysis", "processing", "stimulus", "stimulus/presentation",
                              "stimulus/templates", "general", "units"})
        EXPECT_TRUE(hdf5::open_group(in.value().id(), group)) << group;
    EXPECT_EQ(hdf5::text_attribute(in.value().id(), "nwb_version"), "2.6.0");
    for (const char* text : {"identifier", "session_description", "session_start_time",
                             "timestamps_reference_time", "file_create_date"})
        EXPECT_GT(H5Lexists(in.value().id(), text, H5P_DEFAULT), 0) << text;
    const auto units = value_or_throw(hdf5::open_group(in.value().id(), "units"));
    const hid_t table = units.id();
    EXPECT_EQ(value_or_throw(hdf5::read_whole_numbers(table, "id")), (std::vector<std::uint64_t>{2, 4}));
    EXPECT_EQ(value_or_throw(hdf5::read_numbers(table, "spike_times")), (std::vector<double>{2, 1, 3}));
    EXPECT_EQ(value_or_throw(hdf5::read_whole_numbers(table, "spike_times_index")),
              (std::vector<std::uint64_t>{1, 3}));
    const hdf5::Dataset index(H5Dopen2(table, "spike_times_index", H5P_DEFAULT));
    EXPECT_EQ(hdf5::text_attribute(index.id(), "neurodata_type"), "VectorIndex");
    EXPECT_EQ(hdf5::text_attribute(index.id(), "namespace"), "hdmf-common");
    fs::remove(file);
}

}  // namespace
}  // namespace afferent
