#include "afferent/runtime/result.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace afferent {
namespace {

Result<std::unique_ptr<int>> number(bool good) {
    if (!good) return Error{Error::Kind::malformed, "no number"};
    return std::make_unique<int>(3);
}

Result<void> step(bool good) {
    if (!good) return Error{Error::Kind::closed, "no step"};
    return success();
}

// The value is moved, and the error keeps its kind where the two results differ in type.
Result<int> doubled(bool good_step, bool good_number) {
    AFFERENT_TRY(step(good_step));
    AFFERENT_TRY(found, number(good_number));
    const std::unique_ptr<int> owned = std::move(found);
    return 2 * *owned;
}

TEST(Try, GoesOnWithTheValue) {
    const Result<int> result = doubled(true, true);
    ASSERT_TRUE(result);
    EXPECT_EQ(result.value(), 6);
}

TEST(Try, LeavesWithTheFirstError) {
    EXPECT_EQ(doubled(false, false).error().text, "no step");
    const Result<int> result = doubled(true, false);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, Error::Kind::malformed);
    EXPECT_EQ(result.error().text, "no number");
}

}  // namespace
}  // namespace afferent
