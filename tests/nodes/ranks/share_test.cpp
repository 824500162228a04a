#include "afferent/nodes/ranks/share.hpp"

#include <gtest/gtest.h>

namespace afferent::ranks {
namespace {

TEST(Share, IsOfAPlanOnWhichAllRanksAgree) {
    EXPECT_EQ(disagreement_in({"+grasp"}), "");
    EXPECT_EQ(disagreement_in({"+grasp", "+grasp", "+grasp"}), "");
    EXPECT_EQ(disagreement_in({"+grasp", "+grasp", "+press"}),
              "rank 2 has read another scene than rank 0, or is another version of this program");
}

TEST(Share, IsRefusedWithTheRankWhoseSceneIsWrongUnlessAllAre) {
    EXPECT_EQ(disagreement_in({"-no such file", "-no such file"}), "no such file");
    EXPECT_EQ(disagreement_in({"+grasp", "-no such file"}), "rank 1: no such file");
}

}  // namespace
}  // namespace afferent::ranks
