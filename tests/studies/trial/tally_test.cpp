#include "afferent/studies/trial/tally.hpp"

#include <gtest/gtest.h>

#include "afferent/studies/trial/published.hpp"

namespace afferent {
namespace {

Presentation presented(std::uint32_t number, Outcome outcome, bool slippery = false) {
    Presentation one;
    one.number = number;
    one.outcome = outcome;
    one.slippery = slippery;
    one.peak_force_n = number;
    return one;
}

TEST(Tally, CountsObjectsThatBreakApartFromThoseThatSlip) {
    const std::vector<Presentation> all{
        presented(0, Outcome::broken), presented(1, Outcome::held),    presented(2, Outcome::dropped, true),
        presented(3, Outcome::broken), presented(4, Outcome::dropped), presented(5, Outcome::held, true)};
    const auto [delicate, slippery] = tally(all);
    EXPECT_EQ(delicate.presentations(), 4U);
    EXPECT_EQ(delicate.broken().hits, 2U);
    EXPECT_EQ(delicate.dropped().hits, 1U);
    EXPECT_EQ(delicate.failed().hits, 3U);
    EXPECT_EQ(delicate.failed().of, 4U);
    EXPECT_DOUBLE_EQ(delicate.mean_peak_n(), 2);
    EXPECT_EQ(slippery.presentations(), 2U);
    EXPECT_EQ(slippery.broken().hits, 0U);
    EXPECT_EQ(slippery.dropped().hits, 1U);
}

TEST(Tally, TellsHowSoonSlipsAreAnswered) {
    Tally all;
    EXPECT_FALSE(all.reaction_s(0.5));
    for (int i = 10; i >= 1; --i) {
        Presentation one = presented(0, Outcome::held, true);
        one.slip_onset_s = 1;
        one.slip_reaction_s = 0.01 * i;
        all.add(one);
    }
    Presentation unanswered = presented(0, Outcome::dropped, true);
    unanswered.slip_onset_s = 1;
    unanswered.safe_state = true;
    all.add(unanswered);
    all.add(presented(0, Outcome::held, true));
    EXPECT_EQ(all.slips(), 11U);
    EXPECT_EQ(all.reactions(), 10U);
    EXPECT_EQ(all.safe_state().hits, 1U);
    EXPECT_EQ(all.reaction_s(0), 0.01) << "the quickest";
    EXPECT_EQ(all.reaction_s(0.1), 0.01) << "one of ten";
    EXPECT_EQ(all.reaction_s(0.5), 0.05);
    EXPECT_EQ(all.reaction_s(1), 0.01 * 10);
}

TEST(Tally, TellsWhichSlipsEndedAndWhichPulsesWereFalse) {
    Tallies all;
    const auto slipped = [&](Outcome outcome, double mm) {
        Presentation one = presented(0, outcome, true);
        one.slip_onset_s = 1;
        one.slipped_mm = mm;
        all.slippery.add(one);
    };
    EXPECT_FALSE(all.slippery.slipped_mm(0.5));
    slipped(Outcome::held, 3);
    slipped(Outcome::dropped, 21);
    slipped(Outcome::held, 1);
    all.slippery.add(presented(0, Outcome::dropped, true));
    EXPECT_EQ(all.slippery.stopped().hits, 2U);
    EXPECT_EQ(all.slippery.stopped().of, 3U);
    EXPECT_EQ(all.slippery.slipped_mm(0.5), 3);
    Presentation nervous = presented(0, Outcome::broken);
    nervous.false_pulses = 2;
    all.delicate.add(nervous);
    EXPECT_EQ(all.false_pulses().hits, 1U);
    EXPECT_EQ(all.false_pulses().of, 5U);
}

TEST(Tally, TellsHowSoonContactsAreKnownAndAnswered) {
    Tally all;
    EXPECT_FALSE(all.told_s(0.5) || all.answer_s(0.5));
    for (const double answer_s : {0.03, 0.01, 0.02}) {
        Presentation one = presented(0, Outcome::held);
        one.told_s = answer_s / 2;
        one.answer_s = answer_s;
        all.add(one);
    }
    all.add(presented(0, Outcome::broken));
    EXPECT_EQ(all.told_s(0.5), 0.01);
    EXPECT_EQ(all.answer_s(0.1), 0.01);
    EXPECT_EQ(all.answer_s(0.5), 0.02);
    EXPECT_EQ(all.answer_s(1), 0.03);
}

TEST(Tally, ComparesWhatBreaksOfTheDelicateObjectsAlone) {
    // Of four delicate objects two break under the first condition and one under the second; what the heavy
    // ones do does not count.
    const std::vector<Presentation> first{presented(0, Outcome::broken), presented(1, Outcome::held, true),
                                          presented(2, Outcome::broken), presented(3, Outcome::held),
                                          presented(4, Outcome::held)};
    const std::vector<Presentation> second{presented(0, Outcome::held), presented(1, Outcome::dropped, true),
                                           presented(2, Outcome::broken), presented(3, Outcome::dropped),
                                           presented(4, Outcome::held)};
    const auto found = broken_difference(first, second);
    ASSERT_TRUE(found);
    EXPECT_DOUBLE_EQ(found->value, -0.25);
    EXPECT_FALSE(broken_difference({}, second));
}

TEST(Tally, PairsPresentationsOfTheSameNumber) {
    const std::vector<Presentation> one{presented(1, Outcome::broken), presented(2, Outcome::broken),
                                        presented(3, Outcome::held), presented(9, Outcome::held)};
    const std::vector<Presentation> other{presented(0, Outcome::broken), presented(2, Outcome::held),
                                          presented(3, Outcome::held), presented(5, Outcome::broken),
                                          presented(9, Outcome::broken)};
    const PairedCount count =
        paired(one, other, [](const Presentation& each) { return each.outcome == Outcome::broken; });
    EXPECT_EQ(count.of(), 3U);
    EXPECT_EQ(count.only_first, 1U);
    EXPECT_EQ(count.only_second, 1U);
    EXPECT_EQ(count.neither, 1U);
}

// The figures of the paper (docs/trial.md).
TEST(Published, HasTheThreeFiguresOfWhichTheThirdIsNotFitted) {
    EXPECT_DOUBLE_EQ(published("none").value().broken.value(), 0.275);
    EXPECT_DOUBLE_EQ(published("force").value().broken.value(), 0.14);
    EXPECT_DOUBLE_EQ(published("rate").value().broken.value(), 0.145);
    EXPECT_TRUE(published("none").value().is_fitted);
    EXPECT_TRUE(published("force").value().is_fitted);
    EXPECT_FALSE(published("rate").value().is_fitted);
    EXPECT_FALSE(published("filter"));
    // About ±6, ±5 and ±5 points.
    const auto half = [](std::string_view condition) {
        const Bounds bounds = interval_95(published(condition).value().broken);
        return 50 * (bounds.high - bounds.low);
    };
    EXPECT_NEAR(half("none"), 6, 0.5);
    EXPECT_NEAR(half("force"), 5, 0.5);
    EXPECT_NEAR(half("rate"), 5, 0.5);
}

}  // namespace
}  // namespace afferent
