// Bars, and panels in rows and columns, as the trial draws them.
#include <gtest/gtest.h>

#include <limits>

#include "afferent/io/pictures/bar_picture.hpp"
#include "afferent/io/pictures/panel_grid.hpp"
#include "tests/io/pictures/picture_files.hpp"

namespace afferent {
namespace {

BarPicture some_bars() {
    return {.title = "Broken `date` objects' share",
            .y_title = "broken (%)",
            .names = {"none", "send_on_delta"},
            .series = {{.name = "here", .bars = {BarPicture::Bar{27.6, 27, 28.2}, BarPicture::Bar{9, 8, 10}}},
                       {.name = "the paper", .bars = {BarPicture::Bar{27.5, 22, 34}}, .is_reference = true}},
            .note = "What stands below"};
}

PanelGrid some_panels() {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    PanelGrid::Panel steps{.title = "first",
                           .x_title = "lambda (N)",
                           .y_title = "broken (%)",
                           .curves = {{.name = "none", .x = {1, 2, 3}, .y = {3, unknown, 4}},
                                      {.name = "rate",
                                       .x = {1, 2, 3},
                                       .y = {1, 2, 1.5},
                                       .low = {0.5, 1, 1},
                                       .high = {2, 3, 2},
                                       .marked = true}},
                           .levels = {{"limit", 3.5}, {"as calibrated", 2, true}}};
    PanelGrid picture{.title = "Panels", .columns = 2, .panels = {steps, steps, {}}};
    picture.panels[1].logarithmic_x = true;
    return picture;
}

TEST_F(Picture, ShowsBarsWithTheirValues) {
    expect_drawn(draw(some_bars(), stem()));
    for (const char* text : {"27.6", "27.5", "9", "send on delta", "What stands below"})
        EXPECT_EQ(times_in_svg(text), 1) << text;
}

TEST_F(Picture, LeavesBarsOutThatAreNotKnown) {
    BarPicture picture = some_bars();
    picture.series[0].bars = {std::nullopt, std::nullopt};
    picture.series[1].bars = {};
    expect_drawn(draw(picture, stem()));
    EXPECT_EQ(times_in_svg("27.6"), 0);
    EXPECT_EQ(draw(BarPicture{}, stem()).outcome, Drawn::failed);
}

TEST_F(Picture, NamesACurveOnceForAllPanels) {
    expect_drawn(draw(some_panels(), stem()));
    for (const char* text : {"none", "rate", "limit", "as calibrated"})
        EXPECT_EQ(times_in_svg(text), 1) << text;
    EXPECT_EQ(times_in_svg("lambda (N)"), 2);
    for (const char* letter : {"A", "B"}) EXPECT_EQ(times_in_svg(letter), 1) << letter;
    EXPECT_EQ(times_in_svg("C"), 0) << "the third place is empty";
    EXPECT_EQ(draw(PanelGrid{}, stem()).outcome, Drawn::failed);
}

// Of six panels in a row each has room for two tics, where one alone has them at 0.2, 0.4 and so on.
TEST_F(Picture, HasAsManyTicsAsThereIsRoomFor) {
    PanelGrid::Panel panel;
    panel.curves = {{.name = "force", .x = {0, 1.9}, .y = {11, 12}}};
    expect_drawn(draw(PanelGrid{.title = "One", .columns = 1, .panels = {panel}}, stem()));
    EXPECT_EQ(times_in_svg("0.4"), 1);
    expect_drawn(draw(PanelGrid{.title = "Six", .columns = 6, .panels = std::vector(6, panel)}, stem()));
    EXPECT_EQ(times_in_svg("0.4"), 0);
    EXPECT_EQ(times_in_svg("1"), 6);
}

}  // namespace
}  // namespace afferent
