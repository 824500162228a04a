// gnuplot accepts every script, whatever there is to draw.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/io/pictures/gnuplot_script.hpp"
#include "afferent/io/pictures/grasp_picture.hpp"
#include "afferent/io/pictures/plot_data.hpp"
#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/io/pictures/skin_maps.hpp"
#include "afferent/io/pictures/spike_density.hpp"
#include "tests/io/pictures/picture_files.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

std::size_t lines_of(const std::string& block) {
    return static_cast<std::size_t>(std::count(block.begin(), block.end(), '\n')) - 2;
}

TEST(GnuplotScript, LeavesNothingInATextThatGnuplotWouldRun) {
    EXPECT_EQ(gnuplot_text("it's `date`\n"), "'it''s `date` '");
    EXPECT_EQ(gnuplot_data_text("a \"b\"\nEOD"), "\"a 'b' EOD\"");
}

TEST(PlotData, KeepsEveryPeakOfALongCurve) {
    std::vector<double> x(1'000'000);
    std::vector<double> y(x.size(), 0);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
    y[123'456] = 7;
    y[654'321] = -7;
    const std::string block = curve_data("$curve", x, y);
    EXPECT_NE(block.find("\n123456 7 \n"), std::string::npos);
    EXPECT_NE(block.find("\n654321 -7 \n"), std::string::npos);
    EXPECT_LT(lines_of(block), 5000U);
}

TEST(PlotData, LeavesAGapWhereAValueIsUnknown) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> x{0, 1, 2};
    EXPECT_EQ(curve_data("$curve", x, std::vector<double>{1, unknown, 3}),
              "$curve << EOD\n0 1 \n\n2 3 \nEOD\n");
    EXPECT_EQ(band_data("$band", x, std::vector<double>{1, unknown, 3}, std::vector<double>{2, 2, 2}),
              "$band << EOD\n0 0 3 \n\n2 1 5 \nEOD\n");
}

TEST(PlotData, DrawsNoMoreSpikesThanThereArePixels) {
    std::vector<Event> events;
    for (int i = 0; i < 200'000; ++i)
        events.push_back({scene_start + Duration(i), static_cast<Address>(i % 2)});
    EXPECT_LE(lines_of(spike_data("$spikes", events, 0, 1, 2)), 2U);
    EXPECT_LE(lines_of(spike_data("$spikes", events, 0, 200e-6, 2)), 6000U);
    EXPECT_GT(lines_of(spike_data("$spikes", events, 0, 200e-6, 2)), 5000U);
}

// The numbers of a block, line by line; none of an empty line.
std::vector<std::vector<double>> rows_of(const std::string& block) {
    std::istringstream lines(block);
    std::string line;
    std::getline(lines, line);  // its name
    std::vector<std::vector<double>> rows;
    while (std::getline(lines, line) && line != "EOD") {
        std::istringstream numbers(line);
        rows.emplace_back();
        for (double number = 0; numbers >> number;) rows.back().push_back(number);
    }
    return rows;
}

TEST(PlotData, EnvelopesOfACurveHoldAllOfItAndMeetItsMean) {
    // Fast between 0 and 2, under a spike of 9 in one place.
    std::vector<double> x(70'000);
    std::vector<double> y(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] = static_cast<double>(i) * 1e-3;
        y[i] = i % 2 == 0 ? 0 : 2;
    }
    y[33'333] = 9;
    ASSERT_TRUE(wants_envelope(x.size()));
    EXPECT_FALSE(wants_envelope(1000));
    const auto rows = rows_of(envelope_data("$e", x, y));
    EXPECT_LT(rows.size(), 400U);
    for (const auto& row : rows) {
        ASSERT_EQ(row.size(), 4U);
        EXPECT_EQ(row[1], 0);
        const bool near = std::abs(row[0] - x[33'333]) < 0.21;
        EXPECT_EQ(row[2], near && row[2] > 2 ? 9 : 2);
        // One sample of 9 in a point of 400 samples weighs 7/400; an odd number of samples, 1/400.
        EXPECT_NEAR(row[3], 1, near ? 0.025 : 0.005);
    }
    EXPECT_EQ(std::ranges::count_if(rows, [](const auto& row) { return row[2] == 9; }), 2)
        << "a point stands for twice its width, so that two hold the spike";
}

TEST(PlotData, EnvelopesAndBandsLeaveAGapWhereTheCurveDoes) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> x(7000);
    std::vector<double> y(x.size(), 1);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
    std::fill(y.begin() + 3000, y.begin() + 4000, unknown);
    const std::vector<double> half(x.size(), 0.5);
    for (const std::string& block : {envelope_data("$e", x, y), band_data("$b", x, y, half)}) {
        const auto rows = rows_of(block);
        EXPECT_TRUE(std::ranges::any_of(rows, [](const auto& row) { return row.empty(); }));
        for (const auto& row : rows) EXPECT_TRUE(row.empty() || row[0] < 3000 || row[0] >= 4000) << row[0];
    }
    for (const auto& row : rows_of(band_data("$b", x, y, half)))
        EXPECT_TRUE(row.empty() || (row[1] == 0.5 && row[2] == 1.5));
}

// A second of 350 cells; the colour of what is drawn in full is 0, 0, 0.
constexpr SpikeDensity::Hue black{0, 1'000'000, "#000000"};

std::vector<Event> one_each(Address neurons, Duration at) {
    std::vector<Event> events;
    for (Address address = 0; address < neurons; ++address) events.push_back({scene_start + at, address});
    return events;
}

TEST(SpikeDensity, GivesTheRateOfANeuronAtItsPeak) {
    // A spike within a cell of 1/350 s: 350 Hz, however many neurons share a line.
    for (const Address neurons : {1U, 9U, 90U, 91U, 100U, 179U, 10'000U}) {
        SpikeDensity density(0, 1, neurons);
        EXPECT_EQ(density.peak_hz(), 0);
        density.add(one_each(neurons, 500ms));
        EXPECT_NEAR(density.peak_hz(), 350, 1e-9) << neurons;
    }
}

// Three neurons in one row are three times as many spikes, at the same rate.
TEST(SpikeDensity, DividesByTheNeuronsOfARow) {
    const std::vector<std::uint32_t> neurons{3, 0, 1};
    SpikeDensity density(0, 1, neurons);
    density.add(std::vector<Event>(3, {scene_start + 500ms, 0}));
    density.add(std::vector<Event>{{scene_start + 500ms, 2}});
    EXPECT_NEAR(density.peak_hz(), 350, 1e-9);
}

TEST(SpikeDensity, ColoursEqualRatesAlikeWhetherOrNotLinesDivideTheNeurons) {
    for (const Address neurons : {9U, 100U, 1234U}) {
        SpikeDensity density(0, 1, neurons);
        density.add(one_each(neurons, 500ms));
        std::size_t full = 0;
        for (const auto& cell : rows_of(density.data("$d", std::span(&black, 1)))) {
            ASSERT_EQ(cell.size(), 5U);
            EXPECT_TRUE(cell[2] == 0 || cell[2] == 255) << neurons << " neurons: " << cell[2];
            if (cell[2] == 0) {
                ++full;
                EXPECT_NEAR(cell[0], 0.5, 1.0 / 350);
            }
        }
        EXPECT_EQ(full, std::min<std::size_t>(neurons, 90)) << "a cell of each line";
    }
}

TEST(SpikeDensity, PassesOverWhatIsOutsideAndShowsALoneSpikeAmongMany) {
    SpikeDensity density(1, 2, 4);
    const std::vector<Event> outside{
        {scene_start + 999ms, 0}, {scene_start + 2s, 0}, {scene_start + 1500ms, 4}};
    density.add(outside);
    EXPECT_EQ(density.peak_hz(), 0);
    for (int i = 0; i < 100; ++i) density.add(std::vector<Event>{{scene_start + 1200ms, 1}});
    density.add(std::vector<Event>{{scene_start + 1800ms, 3}});
    const auto cells = rows_of(density.data("$d", std::span(&black, 1)));
    const auto lone =
        std::ranges::find_if(cells, [](const auto& cell) { return cell[1] == 3 && cell[2] < 255; });
    ASSERT_NE(lone, cells.end());
    // The square root of a hundredth of full black.
    EXPECT_NEAR((*lone)[2], 255 * 0.9, 1);
}

TEST(SpikeDensity, GivesEachPatchItsHue) {
    const SpikeDensity::Hue hues[] = {{0, 2, "#FF0000"}, {2, 2, "#0000FF"}};
    SpikeDensity density(0, 1, 4);
    density.add(one_each(4, 500ms));
    for (const auto& cell : rows_of(density.data("$d", hues)))
        EXPECT_TRUE(cell[3] == 255 || (cell[2] > cell[4]) == (cell[1] < 2)) << "row " << cell[1];
}

// Contact, hold and release, with the curves of a whole run.
GraspPicture a_grasp() {
    GraspPicture picture;
    picture.title = "It's a `grasp`, {with} \"marks\" @all^over";
    picture.end_s = 10;
    for (int ms = 0; ms < 10'000; ++ms) {
        const double time_s = ms * 1e-3;
        const double force_n = 8 / (1 + std::exp(-6 * (time_s - 3))) / (1 + std::exp(6 * (time_s - 8)));
        picture.time_s.push_back(time_s);
        picture.true_force_n.push_back(force_n);
        picture.estimate_n.push_back(0.9 * force_n);
        picture.sigma_n.push_back(0.2 + 0.1 * force_n);
        picture.rate_hz.push_back(40 * force_n);
        picture.gain.push_back(force_n < 2 ? 1 : std::exp(-(force_n - 2) / 3));
        picture.emg.push_back(time_s < 6 ? 0.4 : 0);
        picture.command.push_back(time_s < 6 ? 0.4 * picture.gain.back() : -0.3);
        for (Address address = 0; address < 9; ++address)
            if ((ms + 7 * static_cast<int>(address)) % (10 + static_cast<int>(80 / (0.1 + force_n))) == 0)
                picture.events.push_back({scene_start + std::chrono::milliseconds(ms), address});
    }
    picture.levels = {{"object's limit", 10}};
    picture.patches = {{"thumb", 0, 3}, {"index", 3, 3}, {"middle_'finger'", 6, 3}};
    return picture;
}

TEST_F(Picture, ShowsAWholeGrasp) {
    expect_drawn(draw(a_grasp(), stem()));
    for (const char* text : {"A", "B", "C", "D", "± 2 σ", "closing EMG"})
        EXPECT_EQ(times_in_svg(text), 1) << text;
    EXPECT_EQ(times_in_svg("E"), 0);
}

TEST_F(Picture, LeavesOutWhatIsNotThere) {
    GraspPicture picture = a_grasp();
    picture.title.clear();
    picture.true_force_n.clear();
    picture.sigma_n.clear();
    picture.events.clear();
    picture.levels.clear();
    picture.emg.assign(picture.time_s.size(), 0);
    picture.command = picture.emg;
    expect_drawn(draw(picture, stem()));
    EXPECT_EQ(times_in_svg("Gain"), 1);
    for (const char* text : {"closing EMG", "motor command"}) EXPECT_EQ(times_in_svg(text), 0) << text;
    picture.emg.clear();
    picture.command.clear();
    expect_drawn(draw(picture, stem()));
    picture.estimate_n.clear();
    picture.gain.clear();
    expect_drawn(draw(picture, stem()));
    picture.patches.clear();
    picture.rate_hz.assign(picture.time_s.size(), 0);
    expect_drawn(draw(picture, stem()));
    picture.rate_hz.clear();
    EXPECT_EQ(draw(picture, stem()).outcome, Drawn::failed);
}

TEST_F(Picture, NamesPatchesOneBelowTheOther) {
    GraspPicture picture = a_grasp();
    picture.levels.clear();
    picture.patches = {
        {"forty", 0, 40}, {"one", 40, 1}, {"another", 41, 1}, {"ein langer Name für eine Fläche", 42, 1}};
    expect_drawn(draw(picture, stem()));
    double last = -100;
    for (const char* name : {"forty", "one", "another", "ein langer Name für e…"}) {
        EXPECT_EQ(times_in_svg(name), 1) << name;
        EXPECT_GE(height_in_svg(name), last + 12) << name << ": 12 pixels are a line";
        last = height_in_svg(name);
    }
    // Where there is no room for all, those that have it are named.
    picture.patches.clear();
    for (Address i = 0; i < 30; ++i) picture.patches.push_back({"patch " + std::to_string(i), i, 1});
    expect_drawn(draw(picture, stem()));
    EXPECT_EQ(times_in_svg("patch 0"), 1);
    EXPECT_EQ(times_in_svg("patch 1"), 0);
    EXPECT_EQ(times_in_svg("patch 4"), 1);
}

TEST_F(Picture, ShowsTenThousandAddresses) {
    GraspPicture picture = a_grasp();
    picture.patches = {{"thumb", 0, 4000}, {"palm", 4000, 6000}};
    std::mt19937 random(1);
    for (Event& event : picture.events) event.address = static_cast<Address>(random() % 10'000);
    expect_drawn(draw(picture, stem()));
}

TEST_F(Picture, ShowsABenchmark) {
    const ScatterPicture picture{
        .title = "Error against run time",
        .x_title = "Time of an event (ns)",
        .y_title = "Largest error (ns)",
        .series = {{"exact", {{40, 1e-3}, {60, 1e-6}}},
                   {"Euler's", {{20, 1e6}, {0, 1}}, false},
                   {.name = "limit", .points = {{20, 1}, {60, 2}}, .marked = false}}};
    expect_drawn(draw(picture, stem()));
    for (const char* name : {"exact", "Euler's", "limit", "Error against run time"})
        EXPECT_EQ(times_in_svg(name), 1) << name;
}

TEST_F(Picture, EndsTheAxesOfABenchmarkBesideItsPoints) {
    expect_drawn(draw(
        ScatterPicture{
            .title = "", .x_title = "", .y_title = "", .series = {{"all", {{0.18, 2e-7}, {1.5, 4e-7}}}}},
        stem()));
    for (const char* tic : {"0.2", "0.5", "1"}) EXPECT_EQ(times_in_svg(tic), 1) << tic;
    for (const char* tic : {"0.1", "2", "10"}) EXPECT_EQ(times_in_svg(tic), 0) << tic;
    EXPECT_EQ(times_in_svg("2·10"), 1);
    // A single point, and none that has a place.
    for (const double y : {3.0, 0.0})
        expect_drawn(
            draw(ScatterPicture{.title = "", .x_title = "", .y_title = "", .series = {{"one", {{9, y}}}}},
                 stem()));
}

TEST_F(Picture, NamesThePlacesOfABenchmark) {
    expect_drawn(draw(ScatterPicture{.title = "",
                                     .x_title = "",
                                     .y_title = "",
                                     .series = {{"filter", {{1, 0.2}, {3, 7}}, false}},
                                     .x_names = {"as told", "dead_thumb", "sine"}},
                      stem()));
    // Without enhanced text, which would lower the t.
    for (const char* name : {"as told", "dead_thumb", "sine"}) EXPECT_EQ(times_in_svg(name), 1) << name;
}

TEST_F(Picture, MapsWhatIsFoundAtEachPlace) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    expect_drawn(draw(SkinMaps{.title = "RA's maps",
                               .places = {{0, 0}, {3, 1}, {-2, 4}},
                               .maps = {{"threshold_um", {20, 80, none}, true},
                                        {"rate", {5, 5, 5}},
                                        {"nothing", {none, none, none}, true},
                                        {"from 0", {0, 0, 0}, true}}},
                      stem()));
    for (const char* text :
         {"RA's maps", "threshold_um", "rate: 5 throughout", "nothing", "from 0", "20", "40", "80"})
        EXPECT_EQ(times_in_svg(text), 1) << text;
    EXPECT_EQ(draw(SkinMaps{}, stem()).outcome, Drawn::failed);
}

// Two sigmas on either side.
TEST_F(Picture, ShowsTheWholeBandOfAnEstimateThatIsKnown) {
    GraspPicture picture;
    for (int i = 0; i < 100; ++i) {
        picture.time_s.push_back(i * 0.01);
        picture.estimate_n.push_back(i < 10 ? 0 : 14);
        picture.sigma_n.push_back(i < 10 ? 1000 : 3);
    }
    picture.end_s = 1;
    expect_drawn(draw(picture, stem()));
    EXPECT_EQ(times_in_svg("20"), 1) << "the axis ends at the first tic from 14 + 2 · 3 N on";
    EXPECT_EQ(times_in_svg("25"), 0);
}

TEST_F(Picture, SaysWhyItCannotBeWritten) {
    const Drawing drawing = draw(a_grasp(), "/absent/folder/grasp");
    EXPECT_EQ(drawing.outcome, Drawn::failed);
    EXPECT_NE(drawing.message.find("/absent/folder/grasp.svg"), std::string::npos) << drawing.message;
}

TEST(Gnuplot, InheritsNoDescriptors) {
    const auto folder = std::filesystem::temp_directory_path() / ("afferent-" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    std::ofstream(folder / "gnuplot") << "#!/bin/sh\nls -l /proc/$$/fd; exit 1\n";
    ::chmod((folder / "gnuplot").c_str(), 0700);
    const std::string file = folder / "a_session";
    const int leaked = ::open(file.c_str(), O_RDWR | O_CREAT, 0600);
    const std::string path = std::getenv("PATH");
    ::setenv("PATH", (folder.string() + ":" + path).c_str(), 1);
    const Drawing drawing = run_gnuplot("");
    ::setenv("PATH", path.c_str(), 1);
    ::close(leaked);
    std::filesystem::remove_all(folder);
    EXPECT_EQ(drawing.outcome, Drawn::failed);
    EXPECT_NE(drawing.message.find("->"), std::string::npos) << drawing.message;
    EXPECT_EQ(drawing.message.find("a_session"), std::string::npos) << drawing.message;
}

TEST(Gnuplot, NeedNotBeInstalled) {
    const std::string path = std::getenv("PATH");
    setenv("PATH", "/absent", 1);
    const Drawing drawing = run_gnuplot("");
    setenv("PATH", path.c_str(), 1);
    EXPECT_EQ(drawing.outcome, Drawn::no_gnuplot);
    EXPECT_EQ(drawing.message, "gnuplot is not installed");
}

}  // namespace
}  // namespace afferent
