// The gain of each condition, as the scene states it and as a search finds it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/gain_report.hpp"
#include "afferent/studies/trial/gain_search.hpp"
#include "tests/studies/trial/example_trial.hpp"

namespace afferent {
namespace {

Scene with_gain(const std::string& condition, double onset_n) {
    Scene scene = example_trial();
    scene::Gain gain = scene.gain;
    gain.onset_n = onset_n;
    scene.trial->conditions = {{condition, gain}};
    return scene;
}

std::string refused_by(const Scene& scene, std::string_view condition = "rate") {
    try {
        Experiment(scene, condition);
    } catch (const SceneError& error) {
        return error.what();
    }
    return "";
}

TEST(ConditionGain, TakesThePlaceOfTheScenes) {
    Scene same = example_trial();
    same.gain.onset_n = 0;
    const auto own = Experiment(with_gain("rate", 0), "rate").present(0, 6);
    EXPECT_EQ(own, Experiment(same, "rate").present(0, 6));
    EXPECT_NE(own, Experiment(example_trial(), "rate").present(0, 6));
}

TEST(ConditionGain, LeavesOtherConditionsTheScenes) {
    EXPECT_EQ(Experiment(with_gain("rate", 0), "force").present(0, 6),
              Experiment(example_trial(), "force").present(0, 6));
}

TEST(ConditionGain, KeepsTheReflexesOfTheSceneWhereItHasNone) {
    Scene scene = with_gain("force", 0);
    scene.gain.brake.emplace();
    scene.gain.pulse.emplace();
    Scene same = example_trial();
    same.gain.onset_n = 0;
    same.gain.brake.emplace();
    same.gain.pulse.emplace();
    EXPECT_EQ(Experiment(scene, "force").present(0, 6), Experiment(same, "force").present(0, 6));

    scene.trial->conditions[0].gain->brake = scene::Brake{.command = 0.5};
    scene.trial->conditions[0].gain->pulse = scene::SlipPulse{.command = 0.5};
    same.gain.brake->command = same.gain.pulse->command = 0.5;
    EXPECT_EQ(Experiment(scene, "force").present(0, 6), Experiment(same, "force").present(0, 6));
}

TEST(ConditionGain, IsThatOfTheSceneWhereOnlyTheNameStands) {
    Scene scene = example_trial();
    scene.trial->conditions = {{"rate", std::nullopt}};
    EXPECT_EQ(Experiment(scene, "rate").present(0, 3), Experiment(example_trial(), "rate").present(0, 3));
}

TEST(ConditionGain, IsRefusedWithTheReason) {
    EXPECT_NE(refused_by(with_gain("rat", 0), "force")
                  .find("trial.condition[0].name: there is no \"rat\": did you mean \"rate\"?"),
              std::string::npos);
    Scene twice = with_gain("rate", 0);
    twice.trial->conditions.push_back({"rate", std::nullopt});
    EXPECT_NE(refused_by(twice).find("trial.condition[1].name: \"rate\" stands there twice"),
              std::string::npos);
    Scene lead = with_gain("rate", 0);
    lead.trial->conditions[0].gain->lead_ms = 100;
    EXPECT_NE(refused_by(lead).find("trial.condition[0].gain.lead_ms must be 0"), std::string::npos);
    lead.trial->conditions[0].name = "filter";
    EXPECT_EQ(refused_by(lead), "");
    Scene pulse = with_gain("rate", 0);
    pulse.trial->conditions[0].gain->pulse.emplace();
    EXPECT_NE(refused_by(pulse).find("trial.condition[0].gain.pulse must be absent"), std::string::npos);
    for (const char* true_to_the_force : {"force", "filter", "send_on_delta"}) {
        pulse.trial->conditions[0].name = true_to_the_force;
        EXPECT_EQ(refused_by(pulse, true_to_the_force), "");
    }
    EXPECT_NE(refused_by(with_gain("rate", 20)).find("gain"), std::string::npos) << "onset above the limit";
}

TEST(CandidateGains, BeginWithTheScenesOwn) {
    const Scene scene = with_gain("rate", 1.5);
    EXPECT_EQ(candidate_gains(scene, "rate").front(), *scene.trial->conditions[0].gain);
    EXPECT_EQ(candidate_gains(scene, "force").front(), scene.gain);
}

TEST(CandidateGains, AreEachTriedOnceAndLessThanTheLimit) {
    const Scene scene = example_trial();
    for (const char* condition : {"force", "rate", "filter"}) {
        const auto gains = candidate_gains(scene, condition);
        for (std::size_t i = 0; i < gains.size(); ++i) {
            EXPECT_EQ(std::ranges::count(gains, gains[i]), 1) << condition << ' ' << i;
            EXPECT_LT(gains[i].onset_n, gains[i].limit_n) << condition << ' ' << i;
            EXPECT_EQ(gains[i].limit_n, scene.gain.limit_n) << condition << ' ' << i;
        }
    }
}

TEST(CandidateGains, HaveALeadWithTheFilterAndABoundWithEventsAlone) {
    const auto number = [](const char* condition, auto&& is_so) {
        return std::ranges::count_if(candidate_gains(example_trial(), condition), is_so);
    };
    const auto has_lead = [](const scene::Gain& gain) { return gain.lead_ms > 0; };
    const auto has_bound = [](const scene::Gain& gain) { return gain.upper_bound_sigmas > 0; };
    EXPECT_EQ(number("force", has_lead), 0);
    EXPECT_EQ(number("rate", has_lead), 0);
    EXPECT_GT(number("filter", has_lead), 0);
    EXPECT_EQ(number("force", has_bound), 0);
    EXPECT_GT(number("rate", has_bound), 0);
    EXPECT_GT(number("filter", has_bound), 0);
}

class FoundGains : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        fronts_ = search_gains(example_trial(), {.conditions = {"force", "rate"},
                                                 .presentations = presentations,
                                                 .held_out_seed = 77,
                                                 .most_dropped = most_dropped});
    }
    static constexpr std::uint32_t presentations = 32;
    static constexpr double most_dropped = 0.2;
    static std::vector<GainFront> fronts_;
};
std::vector<GainFront> FoundGains::fronts_;

TEST_F(FoundGains, AreNotBeatenByEachOther) {
    ASSERT_EQ(fronts_.size(), 2U);
    for (const GainFront& front : fronts_) {
        ASSERT_FALSE(front.gains.empty());
        for (std::size_t i = 1; i < front.gains.size(); ++i) {
            const Tallies& more = front.gains[i - 1].searched;
            const Tallies& less = front.gains[i].searched;
            EXPECT_GT(more.slippery.dropped().hits, less.slippery.dropped().hits) << front.condition;
            EXPECT_LT(more.delicate.failed().hits, less.delicate.failed().hits) << front.condition;
        }
    }
}

TEST_F(FoundGains, AreCountedAgainOnObjectsThatTheyWereNotChosenOn) {
    ASSERT_EQ(fronts_.size(), 2U);
    for (const GainFront& front : fronts_) {
        ASSERT_LT(front.chosen, front.gains.size());
        const GainTrial& one = front.gains[front.chosen];
        Scene scene = example_trial();
        scene.trial->conditions = {{front.condition, one.gain}};
        const Tallies searched = tally(Experiment(scene, front.condition).present(0, presentations));
        EXPECT_EQ(searched.delicate.broken().hits, one.searched.delicate.broken().hits);
        EXPECT_EQ(searched.slippery.dropped().hits, one.searched.slippery.dropped().hits);
        scene.seed = 77;
        EXPECT_EQ(Experiment(scene, front.condition).present(0, presentations), one.held_out);
    }
}

TEST_F(FoundGains, ChooseTheFewestBrokenOfThoseThatDropNoMoreThanAllowed) {
    ASSERT_EQ(fronts_.size(), 2U);
    const auto dropped = [](const GainTrial& one) { return one.searched.slippery.dropped().value(); };
    for (const GainFront& front : fronts_) {
        EXPECT_TRUE(front.is_allowed);
        ASSERT_LT(front.chosen, front.gains.size());
        EXPECT_LE(dropped(front.gains[front.chosen]), most_dropped);
        // Those before it break fewer, and drop too many.
        for (std::size_t i = 0; i < front.chosen; ++i) EXPECT_GT(dropped(front.gains[i]), most_dropped);
    }
}

TEST_F(FoundGains, StandInTheSceneOnceForEachCondition) {
    Scene scene = with_gain("rate", 9);
    scene.trial->conditions.push_back({"inversion", std::nullopt});
    const Scene written = with_chosen_gains(scene, fronts_);
    ASSERT_EQ(written.trial->conditions.size(), 3U);
    EXPECT_EQ(written.trial->conditions[0].name, "inversion");
    EXPECT_EQ(written.trial->conditions[2].name, "rate");
    EXPECT_EQ(written.trial->conditions[2].gain, fronts_[1].gains[fronts_[1].chosen].gain);
    EXPECT_EQ(Scene::from_text(written.text()).trial, written.trial);
}

TEST_F(FoundGains, AreARowEachInTheTable) {
    const auto file = std::filesystem::path(testing::TempDir()) / "gain_search_test.csv";
    ASSERT_TRUE(write_gains(fronts_, file));
    std::ifstream in(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    std::filesystem::remove(file);
    std::size_t gains = 0;
    for (const GainFront& front : fronts_) gains += front.gains.size();
    ASSERT_EQ(lines.size(), 1 + gains);
    EXPECT_TRUE(
        lines[0].starts_with("condition,onset_n,lambda_n,upper_bound_sigmas,lead_ms,searched_broken_pct"))
        << lines[0];
    EXPECT_EQ(std::ranges::count_if(lines, [](const auto& line) { return line.ends_with(",1"); }), 2);
    EXPECT_TRUE(lines[1].starts_with("force,")) << lines[1];
}

TEST_F(FoundGains, AreComparedInTheSamePresentations) {
    ASSERT_EQ(fronts_.size(), 2U);
    const auto expected = broken_difference(fronts_[0].gains[fronts_[0].chosen].held_out,
                                            fronts_[1].gains[fronts_[1].chosen].held_out);
    ASSERT_TRUE(expected);
    const Summary summary = summary_of(fronts_);
    const auto& compared = summary.find("compared")->list();
    ASSERT_EQ(compared.size(), 1U);
    EXPECT_EQ(*compared[0].find("condition")->text(), "rate");
    EXPECT_EQ(*compared[0].find("against")->text(), "force");
    EXPECT_DOUBLE_EQ(compared[0].find("broken")->find("value_points")->number().value(),
                     100 * expected->value);
}

TEST(GainSearch, NeedsObjectsThatBreakAndObjectsThatDrop) {
    for (const double part : {0.0, 1.0}) {
        Scene scene = example_trial();
        scene.trial->slippery.part = part;
        try {
            search_gains(scene, {{"rate"}, 2, 2, 0.1});
            ADD_FAILURE() << part;
        } catch (const SceneError& error) {
            EXPECT_NE(std::string(error.what()).find("trial.slippery.part must be > 0 and < 1"),
                      std::string::npos);
        }
    }
}

TEST(GainSearch, SaysWhereNoGainDropsSoFew) {
    // Objects so heavy that they slip from any grip that the hand is capable of.
    Scene scene = example_trial();
    scene.trial->slippery.weight_n = 1000;
    const auto fronts = search_gains(
        scene, {.conditions = {"force"}, .presentations = 16, .held_out_seed = 2, .most_dropped = 0.1});
    ASSERT_EQ(fronts.size(), 1U);
    EXPECT_FALSE(fronts[0].is_allowed);
    EXPECT_EQ(fronts[0].chosen, fronts[0].gains.size() - 1);
    std::ostringstream said;
    print_gains(fronts, said);
    EXPECT_NE(said.str().find("With every gain of force"), std::string::npos) << said.str();
}

TEST(GainSearch, NeedsAConditionWithFeedback) {
    EXPECT_THROW(search_gains(example_trial(), {{"none"}, 2, 2, 0.1}), SceneError);
}

TEST(GainSearch, StopsWithTheFrontsThatItHas) {
    int calls = 0;
    const auto fronts = search_gains(example_trial(), {.conditions = {"force"},
                                                       .presentations = 64,
                                                       .held_out_seed = 2,
                                                       .most_dropped = 0.1,
                                                       .progress = [&](double share) {
                                                           EXPECT_LE(share, 1);
                                                           return ++calls < 3;
                                                       }});
    EXPECT_TRUE(fronts.empty());
    EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace afferent
