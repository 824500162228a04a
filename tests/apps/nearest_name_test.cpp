#include "afferent/scene/nearest_name.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

const std::vector<std::string> commands{"run", "plan", "tune", "replay", "coprocessor"};

TEST(NearestName, FindsALetterLeftOutInsertedReplacedOrSwapped) {
    EXPECT_EQ(nearest_name("coprocesor", commands), "coprocessor");
    EXPECT_EQ(nearest_name("runn", commands), "run");
    EXPECT_EQ(nearest_name("plam", commands), "plan");
    EXPECT_EQ(nearest_name("rnu", commands), "run");
}

TEST(NearestName, TakesTheNearestAndOfEqualsTheFirst) {
    EXPECT_EQ(nearest_name("tuns", {"tons", "tune", "tuns"}), "tuns");
    EXPECT_EQ(nearest_name("tuna", {"tune", "tuns"}), "tune");
}

TEST(NearestName, SuggestsNothingThatIsFarOff) {
    EXPECT_EQ(nearest_name("fly", commands), std::nullopt);
    EXPECT_EQ(nearest_name("", commands), std::nullopt);
    EXPECT_EQ(nearest_name("run", {}), std::nullopt);
}

}  // namespace
}  // namespace afferent
