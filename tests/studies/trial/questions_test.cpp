// What a trial answers, to its end and where it is stopped. With few objects: the figures are not tested
// here.
#include "afferent/studies/trial/questions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "tests/studies/trial/example_trial.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t few = 2;

// Whose progress is kept, and which stops at that share.
struct ShortTrial {
    TrialEffort until(double stop) {
        return {{"none", "force"}, few, [this, stop](double share) {
                    shares.push_back(share);
                    return share < stop;
                }};
    }
    void expect_to_end() const {
        EXPECT_TRUE(std::ranges::is_sorted(shares));
        EXPECT_DOUBLE_EQ(shares.back(), 1);
        EXPECT_GT(std::ranges::count_if(shares, [](double share) { return share < 1; }), 0);
    }
    std::vector<double> shares;
};

TEST(TrialQuestions, CompareTheSameObjectsUnderEachCondition) {
    ShortTrial effort;
    const ConditionComparison whole = compare_conditions(example_trial(), effort.until(2));
    EXPECT_TRUE(whole.is_whole);
    effort.expect_to_end();
    ASSERT_EQ(whole.rows.size(), 2U);
    for (const TrialRows& row : whole.rows) {
        EXPECT_EQ(row.presentations.size(), few) << row.condition;
        EXPECT_TRUE(row.paper) << "the arrangement is the paper's";
    }
    for (std::uint32_t i = 0; i < few; ++i) {
        EXPECT_EQ(whole.rows[0].presentations[i].slippery, whole.rows[1].presentations[i].slippery);
        EXPECT_NE(whole.rows[0].presentations[i].peak_force_n, whole.rows[1].presentations[i].peak_force_n);
    }
}

TEST(TrialQuestions, SayThatTheyWereStopped) {
    ShortTrial effort;
    const ConditionComparison stopped = compare_conditions(example_trial(), effort.until(0));
    EXPECT_FALSE(stopped.is_whole);
    EXPECT_LT(stopped.rows.size(), 2U);
    EXPECT_FALSE(measure_faults(example_trial(), effort.until(0)).is_whole);
    EXPECT_FALSE(measure_ablations(example_trial(), effort.until(0)).is_whole);
    EXPECT_FALSE(measure_sensitivity(example_trial(), {}, effort.until(0)).is_whole);
}

TEST(TrialQuestions, ShowWhatALinkDoes) {
    ShortTrial effort;
    const TrialAnswer answer = measure_faults(example_trial(), effort.until(2));
    EXPECT_TRUE(answer.is_whole);
    effort.expect_to_end();
    ASSERT_EQ(answer.panels.size(), 2U);
    EXPECT_EQ(answer.panels[0].scale, 100) << "in percent";
    EXPECT_EQ(answer.panels[1].scale, 1);
    std::set<double> losses;
    std::set<double> latencies_ms;
    for (const TrialCell& cell : answer.cells)
        (cell.changed == "link.channel.loss" ? losses : latencies_ms).insert(cell.value.value());
    EXPECT_EQ(*losses.begin(), 0);
    EXPECT_EQ(*losses.rbegin(), 1);
    EXPECT_EQ(*latencies_ms.rbegin(), 100);
    EXPECT_EQ(answer.cells.size(), 2 * (losses.size() + latencies_ms.size())) << "each under each condition";
}

// A number with a panel of its own is tried at five values, any other at the two ends of its range.
TEST(TrialQuestions, AskEachNumberOverItsRange) {
    const TrialNumber* const drawn = find_trial_number("trial.user.reaction_ms");
    const TrialNumber* const listed = find_trial_number("trial.emg.bandwidth_hz");
    ASSERT_TRUE(drawn && listed);
    ShortTrial effort;
    const std::array asked{drawn, listed};
    const TrialAnswer answer = measure_sensitivity(example_trial(), asked, effort.until(2));
    EXPECT_TRUE(answer.is_whole);
    effort.expect_to_end();
    ASSERT_EQ(answer.panels.size(), 1U);
    EXPECT_EQ(answer.panels[0].path, drawn->path);
    std::vector<double> values;
    for (const TrialCell& cell : answer.cells)
        if (cell.condition == "force" && cell.value) values.push_back(*cell.value);
    EXPECT_EQ(values, (std::vector<double>{drawn->low, std::lerp(drawn->low, drawn->high, 0.25),
                                           std::midpoint(drawn->low, drawn->high),
                                           std::lerp(drawn->low, drawn->high, 0.75), drawn->high, listed->low,
                                           listed->high}));
    EXPECT_EQ(answer.cells.size(), 2 * values.size() + 2) << "and the scene as it is";
}

}  // namespace
}  // namespace afferent
