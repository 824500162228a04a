// Where touches begin and end.
#include "afferent/decoders/edge.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/summary.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

// Nine afferents a millimetre apart, at the addresses 1 to 9 of 12, and 50 ms to settle.
EdgeReadout::Parameters nine_afferents() {
    EdgeReadout::Parameters parameters{.addresses = 12, .patch = {2}, .settle = 50ms};
    for (int i = 0; i < 9; ++i)
        parameters.afferents.push_back({static_cast<Address>(i + 1), {{i % 3 - 1.0, i / 3 - 1.0, 0.25}, 1}});
    return parameters;
}

// An edge slides along x at 100 mm/s: each column 10 ms after the one before.
std::vector<Event> slide_from(Duration begin) {
    std::vector<Event> events;
    for (int i = 0; i < 9; ++i) events.push_back({at(begin + (i % 3) * 10ms), static_cast<Address>(i + 1)});
    // Others, and second spikes.
    events.push_back({at(begin + 25ms), 0});
    events.push_back({at(begin + 26ms), 11});
    events.push_back({at(begin + 27ms), 1});
    std::sort(events.begin(), events.end());
    return events;
}

// In spans of 5 ms, to their end.
void hear(EdgeReadout& readout, std::span<const Event> events, Duration begin, Duration end) {
    for (; begin < end; begin += 5ms) {
        std::vector<Event> span;
        for (const Event& event : events)
            if (event.time >= at(begin) && event.time < at(begin + 5ms)) span.push_back(event);
        readout.observe(at(begin), at(begin + 5ms), span);
    }
}

TEST(EdgeReadout, TellsATouchOnceNobodyJoinsIt) {
    EdgeReadout readout(nine_afferents());
    const auto events = slide_from(100ms);
    hear(readout, events, 0ms, 170ms);
    EXPECT_EQ(readout.next(), nullptr) << "the last has fired for the first time at 120 ms";
    hear(readout, events, 170ms, 180ms);
    ASSERT_NE(readout.next(), nullptr);
    const EdgeTouch touch = *readout.next();
    EXPECT_EQ(touch.begin, at(100ms));
    EXPECT_EQ(touch.told, at(170ms));
    EXPECT_EQ(touch.patch.value, 2U);
    EXPECT_EQ(touch.afferents, 9U);
    EXPECT_TRUE(touch.edge.slides);
    EXPECT_NEAR(touch.edge.orientation_deg, 90, 1e-3);
    EXPECT_NEAR(touch.edge.speed_mm_per_s, 100, 1e-2);
    readout.take();
    EXPECT_EQ(readout.next(), nullptr);
}

TEST(EdgeReadout, BeginsATouchOnlyAfterSilence) {
    EdgeReadout readout(nine_afferents());
    std::vector<Event> events;
    // One afferent goes on firing every 40 ms; the others fire again all the same.
    for (const Duration begin : {100ms, 300ms})
        for (const Event& event : slide_from(begin)) events.push_back(event);
    for (Duration time = 130ms; time < 400ms; time += 40ms) events.push_back({at(time), 5});
    std::sort(events.begin(), events.end());
    hear(readout, events, 0ms, 400ms);
    ASSERT_NE(readout.next(), nullptr);
    readout.take();
    EXPECT_EQ(readout.next(), nullptr) << "the patch has not been silent";
    hear(readout, slide_from(500ms), 400ms, 600ms);
    ASSERT_NE(readout.next(), nullptr);
    EXPECT_EQ(readout.next()->begin, at(500ms));
}

TEST(EdgeReadout, TellsNothingOfTooFew) {
    EdgeReadout readout(nine_afferents());
    auto events = slide_from(100ms);
    std::erase_if(events, [](const Event& event) { return event.address > 7; });
    hear(readout, events, 0ms, 300ms);
    EXPECT_EQ(readout.next(), nullptr);
}

// A loss is no silence: the touch is told as it was before, and the next begins after a silence that is
// known.
TEST(EdgeReadout, TakesALossForNeitherSpikesNorSilence) {
    EdgeReadout readout(nine_afferents());
    const auto events = slide_from(100ms);
    hear(readout, events, 0ms, 125ms);
    readout.lose(at(125ms), at(130ms));
    ASSERT_NE(readout.next(), nullptr);
    EXPECT_EQ(readout.next()->told, at(125ms));
    EXPECT_EQ(readout.next()->afferents, 9U);
    readout.take();
    hear(readout, slide_from(150ms), 130ms, 300ms);
    EXPECT_EQ(readout.next(), nullptr) << "20 ms of silence are too few";
    hear(readout, slide_from(400ms), 300ms, 500ms);
    EXPECT_NE(readout.next(), nullptr);
}

// A span that is missing is lost.
TEST(EdgeReadout, TakesWhatIsMissingForLost) {
    EdgeReadout readout(nine_afferents());
    hear(readout, {}, 0ms, 100ms);
    hear(readout, slide_from(120ms), 105ms, 300ms);
    EXPECT_EQ(readout.next(), nullptr);
}

// Two parts of a span that ends in silence are one span.
TEST(EdgeReadout, WaitsForAllPartsOfASpan) {
    EdgeReadout whole(nine_afferents());
    EdgeReadout parts(nine_afferents());
    const auto events = slide_from(100ms);
    hear(whole, {}, 0ms, 100ms);
    hear(parts, {}, 0ms, 100ms);
    whole.observe(at(100ms), at(400ms), events);
    parts.observe(at(100ms), at(400ms), std::span(events).first(4));
    parts.observe(at(100ms), at(400ms), std::span(events).subspan(4));
    hear(whole, {}, 400ms, 410ms);
    hear(parts, {}, 400ms, 410ms);
    ASSERT_NE(whole.next(), nullptr);
    ASSERT_NE(parts.next(), nullptr);
    EXPECT_EQ(*parts.next(), *whole.next());
}

TEST(EdgeReadout, ContinuesFromASnapshotBitForBit) {
    EdgeReadout readout(nine_afferents());
    const auto events = slide_from(100ms);
    hear(readout, events, 0ms, 115ms);
    EdgeReadout other(nine_afferents());
    other.resume(readout.snapshot());
    for (EdgeReadout* each : {&readout, &other}) hear(*each, events, 115ms, 200ms);
    ASSERT_NE(readout.next(), nullptr);
    ASSERT_NE(other.next(), nullptr);
    EXPECT_EQ(*other.next(), *readout.next());
    EdgeReadout::Snapshot alien = readout.snapshot();
    alien.firsts.push_back({9, 0});
    EXPECT_THROW(other.resume(alien), ParameterError);
}

// In the middle nobody knows whether the patch is touched.
TEST(EdgeReadout, WaitsForSilenceWhereItBeginsInTheMiddle) {
    EdgeReadout readout(nine_afferents());
    readout.restart(at(90ms));
    hear(readout, slide_from(100ms), 90ms, 300ms);
    EXPECT_EQ(readout.next(), nullptr);
    hear(readout, slide_from(400ms), 300ms, 600ms);
    EXPECT_NE(readout.next(), nullptr);
    readout.restart(scene_start);
    hear(readout, slide_from(0ms), 0ms, 100ms);
    EXPECT_NE(readout.next(), nullptr) << "a scene begins untouched";
}

TEST(EdgeReadout, WaitsForSilenceWhereItIsResumed) {
    EdgeReadout readout(nine_afferents());
    readout.resume_after(at(90ms), at(90ms));
    hear(readout, slide_from(100ms), 90ms, 300ms);
    EXPECT_EQ(readout.next(), nullptr);
    hear(readout, slide_from(400ms), 300ms, 600ms);
    EXPECT_NE(readout.next(), nullptr);
}

TEST(EdgeReadout, DropsTheOldestOfTouchesThatNobodyTakes) {
    EdgeReadout readout(nine_afferents());
    const int touches = EdgeReadout::most_untaken + 3;
    for (int i = 0; i < touches; ++i) hear(readout, slide_from(i * 200ms + 60ms), i * 200ms, (i + 1) * 200ms);
    EXPECT_EQ(readout.dropped(), 3U);
    ASSERT_NE(readout.next(), nullptr);
    EXPECT_EQ(readout.next()->begin, at(3 * 200ms + 60ms));
}

TEST(EdgeReadout, CountsTheTouchesOfARunAndKeepsTheLast) {
    EdgeReadout::Totals totals;
    Summary summary;
    totals.add_to(summary, "tip");
    EXPECT_EQ(summary["touches"]["tip"]["told"].number(), 0.0);
    EXPECT_EQ(summary["touches"]["tip"].entries().size(), 1U);
    for (const double orientation_deg : {30.0, 40.0})
        totals.add({.patch = {2}, .edge = {.orientation_deg = orientation_deg, .sigma_deg = 5}});
    totals.add_to(summary, "tip");
    EXPECT_EQ(summary["touches"]["tip"]["told"].number(), 2.0);
    EXPECT_EQ(summary["touches"]["tip"]["last_orientation_deg"].number(), 40.0);
    EXPECT_EQ(summary["touches"]["tip"]["last_orientation_sigma_deg"].number(), 5.0);
}

// A column as text, as a table has it.
template <class Readout>
std::vector<std::string> columns_of(const Readout& readout) {
    std::vector<std::string> columns;
    const auto text = [](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, TimePoint>)
            return std::to_string((value - scene_start) / 1ms);
        else if constexpr (std::is_same_v<Value, PatchIndex>)
            return std::to_string(value.value);
        else if constexpr (std::is_same_v<Value, std::optional<double>>)
            return value ? std::to_string(std::lround(*value)) : "";
        else
            return std::to_string(std::lround(value));
    };
    readout.columns(
        [&](const char* name, const auto& value) { columns.push_back(name + ("=" + text(value))); });
    return columns;
}

TEST(PatchContact, HasAColumnForEachOfItsValues) {
    PatchContact contact{.time = at(1ms),
                         .patch = {2},
                         .contact = 1,
                         .estimate = {3, 4, 5, 6, 7, 8, 9, 10, 11, true, 12, 13, 14, 15}};
    std::vector<std::string> columns{"time=1",
                                     "patch=2",
                                     "contact=1",
                                     "afferents=3",
                                     "force_n=4",
                                     "force_sigma_n=5",
                                     "x_mm=6",
                                     "x_sigma_mm=7",
                                     "y_mm=8",
                                     "y_sigma_mm=9",
                                     "area_mm2=10",
                                     "area_sigma_mm2=11",
                                     "velocity_x_mm_per_s=12",
                                     "velocity_x_sigma_mm_per_s=13",
                                     "velocity_y_mm_per_s=14",
                                     "velocity_y_sigma_mm_per_s=15"};
    EXPECT_EQ(columns_of(contact), columns);
    contact.estimate.slides = false;
    columns[12] = "velocity_x_mm_per_s=";
    columns[13] = "velocity_x_sigma_mm_per_s=";
    columns[14] = "velocity_y_mm_per_s=";
    columns[15] = "velocity_y_sigma_mm_per_s=";
    EXPECT_EQ(columns_of(contact), columns) << "what stands has no velocity";
    contact.estimate.afferents = 0;
    columns[3] = "afferents=0";
    columns[6] = "x_mm=";
    columns[7] = "x_sigma_mm=";
    columns[8] = "y_mm=";
    columns[9] = "y_sigma_mm=";
    EXPECT_EQ(columns_of(contact), columns) << "no contact is nowhere";
}

TEST(EdgeTouch, HasAColumnForEachOfItsValues) {
    EdgeTouch touch{
        .begin = at(1ms), .patch = {2}, .told = at(3ms), .afferents = 4, .edge = {false, 5, 6, 7, 8, 9}};
    std::vector<std::string> columns{"time=1",         "patch=2",           "told=3",
                                     "afferents=4",    "orientation_deg=5", "orientation_sigma_deg=6",
                                     "direction_deg=", "speed_mm_per_s=",   "speed_sigma_mm_per_s="};
    EXPECT_EQ(columns_of(touch), columns) << "what does not slide has no speed";
    touch.edge.slides = true;
    columns[6] += "7";
    columns[7] += "8";
    columns[8] += "9";
    EXPECT_EQ(columns_of(touch), columns);
}

TEST(EdgeReadout, RefusesWhatItCannotRead) {
    auto parameters = nine_afferents();
    parameters.settle = 0ms;
    EXPECT_THROW(EdgeReadout{parameters}, ParameterError);
    parameters = nine_afferents();
    parameters.afferents[3].address = 12;
    EXPECT_THROW(EdgeReadout{parameters}, ParameterError);
}

}  // namespace
}  // namespace afferent
