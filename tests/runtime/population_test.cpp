#include "afferent/runtime/population.hpp"

#include <gtest/gtest.h>

#include "afferent/runtime/skin.hpp"

namespace afferent {
namespace {

TEST(Population, HasTheAfferentsOfAllItsPatches) {
    Population population;
    EXPECT_EQ(population.size(), 0U);
    population.patches = {{"thumb", 3, ""}, {"index", 4, ""}};
    EXPECT_EQ(population.size(), 7U);
}

TEST(Population, HasKindsAndPositionsWhereOneHasThem) {
    Population population;
    population.patches = {{"thumb", 1, ""}, {"index", 1, ""}};
    population.afferents.resize(2);
    EXPECT_FALSE(population.has_kinds());
    EXPECT_FALSE(population.has_positions());
    population.patches[1].kind = "SA1";
    population.afferents[1].place = Position{0, 0};
    EXPECT_TRUE(population.has_kinds());
    EXPECT_TRUE(population.has_positions());
}

TEST(SkinElement, HasAPressureWhereItHasASize) {
    EXPECT_EQ(Skin::Element().pressure_kpa(1), 0);
    EXPECT_EQ((Skin::Element{.place = {}, .width_mm = 2}).pressure_kpa(1), 250);
}

}  // namespace
}  // namespace afferent
