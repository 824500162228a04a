// The hand's end of a link by itself.
#include "afferent/nodes/hand_end.hpp"

#include <gtest/gtest.h>

#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

TEST(HandEnd, HasTheStateThatItIsGiven) {
    const Plan plan =
        make_plan(Scene::from_text("source { profile { point { force_n: 1 } } } link { tcp {} }"));
    const auto opened = value_or_throw(HandEnd::open(plan));
    HandEnd& end = *opened;
    for (const GripState state : {GripState::frozen, GripState::safe, GripState::operating}) {
        end.set_state(state);
        EXPECT_EQ(end.state(), state);
        EXPECT_EQ(end.memory().state, state);
    }
}

// Without a controller there is no grip to guard.
TEST(HandEnd, OperatesWhereNobodyReadsTheEstimate) {
    const Plan plan =
        make_plan(Scene::from_text("source { profile { point { force_n: 1 } } } link { tcp {} } record { "
                                   "force: false picture: false }"));
    const auto opened = value_or_throw(HandEnd::open(plan));
    HandEnd& end = *opened;
    ASSERT_EQ(end.controller(), nullptr);
    end.set_state(GripState::safe);
    EXPECT_EQ(end.state(), GripState::operating);
}

}  // namespace
}  // namespace afferent
