// The skin from above and its spikes, as a picture and as a movie.
#include "afferent/io/pictures/population_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <set>

#include "afferent/io/pictures/movie.hpp"
#include "afferent/io/pictures/rate_colours.hpp"
#include "tests/io/pictures/picture_files.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

// ---- rows

Population of_two_kinds() {
    return {.patches = {{"skin", 3, "SA1"}, {"deep", 1, "PC"}, {"more skin", 2, "SA1"}},
            .afferents = {{.place = Position{2, 0}},
                          {.place = Position{-1, 5}},
                          {.place = std::nullopt},
                          {.place = Position{0, 0}},
                          {.place = Position{1, -7}},
                          {.place = Position{-3, 0}}}};
}

TEST(PopulationRows, AreByKindAndThenByPosition) {
    const PopulationRows along_x(of_two_kinds(), 0);
    ASSERT_EQ(along_x.kinds().size(), 2U);
    EXPECT_EQ(along_x.kinds()[0].name, "SA1");
    EXPECT_EQ(along_x.kinds()[0].rows, 5U);
    EXPECT_EQ(along_x.kinds()[1].first, 5U);
    // Four rows from x = 2 down to -3: address 0 (2), 4 (1), 1 (-1), 5 (-3); and 2 without a position.
    for (const auto& [address, row] : {std::pair{0U, 0U}, {4U, 1U}, {1U, 2U}, {5U, 3U}, {2U, 4U}, {3U, 5U}})
        EXPECT_EQ(along_x.row(address), row) << address;
    EXPECT_EQ(along_x.along_mm(0), 2);
    EXPECT_NEAR(along_x.along_mm(1), 2 - 5.0 / 3, 1e-12);
    EXPECT_TRUE(std::isnan(along_x.along_mm(4)));
    EXPECT_EQ(along_x.afferents(), std::vector<std::uint32_t>(6, 1));
    const PopulationRows along_y(of_two_kinds(), 90);
    // From y = 5 down to -7, in steps of 4 mm; addresses 0 and 5 are both at 0.
    EXPECT_EQ(along_y.row(4), 3U);
    EXPECT_EQ(along_y.row(0), along_y.row(5));
    EXPECT_EQ(along_y.afferents(), (std::vector<std::uint32_t>{1, 2, 0, 1, 1, 1}));
    // The cosine of 90 degrees is 6e-17 in a double, and positions are a few mm.
    EXPECT_NEAR(along_y.along_mm(3), -7, 1e-12);
}

// Whatever the afferents' positions, equal times are equal distances.
TEST(PopulationRows, MakeAConstantSpeedAStraightLine) {
    Population population{.patches = {{"skin", 200, "SA1"}}, .afferents = {}};
    for (int i = 0; i < 200; ++i) population.afferents.push_back({.place = Position{0.001 * i * i, 0}});
    const PopulationRows rows(population, 0);
    for (std::uint32_t address = 0; address < 200; ++address)
        EXPECT_NEAR(rows.row(address), 199 - 199 * population.afferents[address].place->x_mm / 39.601, 0.5);
    for (std::uint32_t row = 1; row < 200; ++row)
        EXPECT_NEAR(rows.along_mm(row - 1) - rows.along_mm(row), 39.601 / 199, 1e-12);
}

TEST(PopulationRows, HaveTheColoursThatAreCommonForTheirKinds) {
    const std::vector<PopulationRows::Kind> kinds{
        {"RA", 0, 1}, {"mine", 1, 1}, {"SA1", 2, 1}, {"yours", 3, 1}};
    EXPECT_EQ(colour_of_kind(kinds, 0), colour_of_kind({{"RA", 0, 1}}, 0));
    std::set<std::string_view> different;
    for (std::size_t i = 0; i < kinds.size(); ++i) different.insert(colour_of_kind(kinds, i));
    EXPECT_EQ(different.size(), kinds.size());
}

// In the order of their rates for every reader: by the weights of red, green and blue in lightness.
TEST(RateColours, AreTheDarkerTheHigherTheRate) {
    double last = 256;
    for (int i = 0; i <= 100; ++i) {
        const int colour = rate_colour(i / 100.0);
        const double light = 0.2126 * (colour >> 16) + 0.7152 * (colour >> 8 & 255) + 0.0722 * (colour & 255);
        EXPECT_LT(light, last) << i;
        last = light;
    }
    EXPECT_EQ(rate_colour(7), rate_colour(1));
}

// ---- pressure

TEST(PressureFrames, HoldEachForceUntilTheNextScanOfItsElement) {
    PressureFrames frames(4, at(10ms), 10ms, 4);
    const auto scan = [&](Duration time, Address first, std::vector<double> forces_n) {
        frames.scan({at(time), first, forces_n});
    };
    scan(0ms, 0, {0, 0, 0, 0});
    scan(5ms, 1, {1, 2});
    scan(12ms, 1, {0});
    scan(20ms, 3, {3});
    ASSERT_EQ(frames.frames().size(), 1U) << "of 20 ms another scan may come";
    frames.finish(at(31ms));
    const auto pressed = [&](std::size_t frame) {
        std::vector<std::pair<std::uint32_t, float>> found;
        for (const auto& [element, force_n] : frames.frames()[frame]) found.emplace_back(element, force_n);
        std::ranges::sort(found);
        return found;
    };
    using Found = std::vector<std::pair<std::uint32_t, float>>;
    ASSERT_EQ(frames.frames().size(), 3U);
    EXPECT_EQ(pressed(0), (Found{{1, 1}, {2, 2}}));
    EXPECT_EQ(pressed(1), (Found{{2, 2}, {3, 3}}));
    EXPECT_EQ(pressed(2), pressed(1));
    EXPECT_EQ(frames.pressed(), 6U);
    frames.finish(at(1s));
    EXPECT_EQ(frames.frames().size(), 4U) << "as many as were asked for";
}

// ---- the picture

// A square centimetre with a grid of afferents of two kinds, which fire as something passes from left to
// right.
struct Touched {
    Population population;
    Skin skin;
    std::vector<Event> events;

    explicit Touched(int across, int times = 1) {
        population.patches = {{"a", static_cast<std::uint32_t>(across * across), "SA1"},
                              {"b", static_cast<std::uint32_t>(across * across), "it's <RA>"}};
        skin.outlines = {{{-5, -5}, {5, -5}, {5, 5}, {-5, 5}}};
        for (int i = 0; i < 100; ++i) skin.elements.push_back({{i % 10 - 4.5, i / 10 - 4.5}, 1});
        const double pitch_mm = 10.0 / across;
        for (int i = 0; i < 2 * across * across; ++i) {
            const Position place{(i % across + 0.5) * pitch_mm - 5,
                                 (i / across % across + 0.5) * pitch_mm - 5};
            population.afferents.push_back({.place = place});
            for (int spike = 0; spike < times; ++spike)
                events.push_back(
                    {at(Duration(static_cast<std::int64_t>((place.x_mm + 5) * 1e8) + spike * 2'000'000)),
                     static_cast<Address>(i)});
        }
        std::ranges::sort(events);
    }
};

class PopulationPictures : public Picture {
  protected:
    // Drawn as it is collected from a run.
    Drawing draw_as_picture(const Touched& touched, bool dense) const {
        const PopulationRows rows(touched.population, 0);
        PopulationPicture picture{.title = "It's a `skin`, {touched}",
                                  .end_s = 1.2,
                                  .population = touched.population,
                                  .skin = touched.skin,
                                  .rows = rows,
                                  .direction = "along x",
                                  .passing = PopulationPicture::Passing{"it", -5, 10},
                                  .from_s = 0.5,
                                  .to_s = 0.55,
                                  .spikes = std::vector<std::uint32_t>(touched.population.afferents.size()),
                                  .pressed = {{3, 0.5F}, {13, 1}, {23, 0.25F}},
                                  .all_spikes = touched.events.size(),
                                  .spikes_of_kind = {1234, 0}};
        for (const Event& event : touched.events) {
            if (event.time >= at(500ms) && event.time < at(550ms)) ++picture.spikes[event.address];
            picture.events.push_back({event.time, rows.row(event.address)});
        }
        if (dense) {
            picture.density.emplace(0, 1.2, rows.rows());
            picture.density->add(picture.events);
        }
        return draw(picture, stem());
    }
};

TEST_F(PopulationPictures, ShowTheSkinAndTheSpikes) {
    expect_drawn(draw_as_picture(Touched(10), false));
    EXPECT_EQ(times_in_svg("100 afferents"), 2);
    EXPECT_EQ(times_in_svg("1,234 spikes"), 1);
    EXPECT_EQ(times_in_svg("SA1"), 2) << "above its map and beside its rows";
    EXPECT_EQ(times_in_svg("from 0.5 to 0.55 s,"), 1);
    EXPECT_EQ(times_in_svg("1e+03 kPa on the skin") + times_in_svg("1000 kPa on the skin"), 1)
        << "1 N on 1 mm²";
    EXPECT_EQ(times_in_svg("hollow: silent"), 1);
    EXPECT_EQ(times_in_svg("shaded: the span above; dashed: it passes"), 1);
}

// A picture has room for some thousand afferents, and for some hundred thousand spikes; it says what it shows
// instead.
TEST_F(PopulationPictures, SayWhatTheyShowInsteadOfTooMuch) {
    expect_drawn(draw_as_picture(Touched(100, 16), true));
    EXPECT_EQ(times_in_svg("squares: mean of"), 1);
    EXPECT_EQ(times_in_svg("10,000 afferents"), 2);
    std::ifstream in(stem().string() + ".svg");
    const std::string svg(std::istreambuf_iterator<char>(in), {});
    EXPECT_NE(
        svg.find("320,000 spikes, too many to draw one by one: the shade is the mean rate, full colour at"),
        std::string::npos);
    EXPECT_LT(svg.size(), 5'000'000U) << "a page that a browser opens at once";
}

TEST_F(PopulationPictures, AreDrawnWhereNothingFires) {
    Touched silent(3);
    silent.events.clear();
    expect_drawn(draw_as_picture(silent, false));
    silent.skin = {};
    silent.skin.elements.resize(100);
    expect_drawn(draw_as_picture(silent, false));
    for (auto& each : silent.population.afferents) each.place.reset();
    EXPECT_EQ(draw_as_picture(silent, false).outcome, Drawn::failed);
}

// ---- the movie

std::string bytes_of_base64(const std::string& text) {
    static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text.substr(0, text.find('='))) {
        bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes += static_cast<char>(bits >> count & 255);
    }
    return bytes;
}

template <class Number>
std::vector<Number> numbers_in(const std::string& page, const std::string& name) {
    const std::string before = '"' + name + "\":\"";
    const std::size_t begin = page.find(before) + before.size();
    const std::string bytes = bytes_of_base64(page.substr(begin, page.find('"', begin) - begin));
    std::vector<Number> numbers(bytes.size() / sizeof(Number));
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

TEST(MoviePage, HasAllEventsPlacesAndPressures) {
    const Touched touched(4);
    const PopulationRows rows(touched.population, 0);
    PressureFrames pressure(100, at(100ms), 50ms, 3);
    const std::vector<double> forces_n{0.5, 1};
    pressure.scan({at(0ms), 7, forces_n});
    pressure.finish(at(1s));
    const std::string page = movie_page({.title = "</script> & \"quotes\"",
                                         .direction = "along x",
                                         .population = touched.population,
                                         .skin = touched.skin,
                                         .rows = rows,
                                         .begin = at(100ms),
                                         .end = at(1s),
                                         .events = touched.events,
                                         .pressure = &pressure,
                                         .pressure_interval = 50ms});
    std::vector<std::uint32_t> times;
    std::vector<std::uint32_t> addresses;
    for (const Event& event : touched.events) {
        times.push_back(static_cast<std::uint32_t>((event.time - at(100ms)) / Duration(1us)));
        addresses.push_back(event.address);
    }
    EXPECT_EQ(numbers_in<std::uint32_t>(page, "times"), times);
    EXPECT_EQ(numbers_in<std::uint32_t>(page, "addresses"), addresses);
    const auto places = numbers_in<float>(page, "places");
    ASSERT_EQ(places.size(), 64U);
    EXPECT_EQ(places[0], -3.75F);
    EXPECT_EQ(places[63], 3.75F);
    EXPECT_EQ(numbers_in<float>(page, "cells"), (std::vector<float>{2.5, -4.5, 1, 3.5, -4.5, 1}));
    EXPECT_EQ(numbers_in<std::uint32_t>(page, "ends"), (std::vector<std::uint32_t>{2, 4, 6}));
    EXPECT_EQ(numbers_in<std::uint8_t>(page, "levels"),
              (std::vector<std::uint8_t>{128, 255, 128, 255, 128, 255}));
    EXPECT_EQ(page.find("</script> &"), std::string::npos) << "a title ends no script";
    EXPECT_EQ(page.find("http"), std::string::npos) << "it needs no network";
    // What else there is: names, outlines, and the pressures.
    EXPECT_NEAR(static_cast<double>(movie_bytes(32, 32)), static_cast<double>(page.size()), 2000);
}

}  // namespace
}  // namespace afferent
