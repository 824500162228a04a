// Presentations from the user's intent to the object: reproducible, alike under all conditions, through the
// product's chain.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "afferent/studies/trial/experiment.hpp"
#include "tests/long_runs.hpp"
#include "tests/studies/trial/example_trial.hpp"

namespace afferent {
namespace {

// With sensors that read what is there, but for the converter's steps.
Scene with_ideal_sensors() {
    Scene scene = example_trial();
    for (scene::Patch& patch : scene.patches) {
        patch.sensor = {};
        patch.sensor.full_scale_n = 10;
    }
    return scene;
}

std::vector<Presentation> all_slippery(Scene scene, std::string_view condition, std::uint32_t count) {
    scene.trial->slippery.part = 1;
    return Experiment(scene, condition).present(0, count);
}

std::size_t number_of(Outcome outcome, const std::vector<Presentation>& presentations) {
    return static_cast<std::size_t>(std::count_if(presentations.begin(), presentations.end(),
                                                  [&](const auto& each) { return each.outcome == outcome; }));
}

class TrialCondition : public testing::TestWithParam<std::string> {};

TEST_P(TrialCondition, GivesTheSameForAnyNumberOfThreads) {
    Scene scene = example_trial();
    scene.link.channel = scene::Channel{.jitter_ms = 3, .loss = 0.05, .reorder = 0.05};
    const auto alone = Experiment(scene, GetParam()).present(5, 12);
    scene.runtime.threads = 3;
    EXPECT_EQ(Experiment(scene, GetParam()).present(5, 12), alone);
    // A presentation does not depend on those before it.
    EXPECT_EQ(Experiment(scene, GetParam()).present(11, 1).at(0), alone.at(6));
    EXPECT_EQ(alone.at(6).number, 11U);
}

TEST_P(TrialCondition, MeetsTheSameUserAndObjectAsAnyOther) {
    const auto others = Experiment(example_trial(), "none").present(0, 12);
    const auto presented = Experiment(example_trial(), GetParam()).present(0, 12);
    ASSERT_EQ(presented.size(), 12U);
    ASSERT_EQ(others.size(), 12U);
    for (std::size_t i = 0; i < others.size(); ++i) {
        EXPECT_EQ(presented[i].slippery, others[i].slippery);
        EXPECT_EQ(presented[i].breaking_force_n, others[i].breaking_force_n);
        EXPECT_EQ(presented[i].stiffness_n_per_mm, others[i].stiffness_n_per_mm);
        EXPECT_EQ(presented[i].weight_n, others[i].weight_n);
        EXPECT_EQ(presented[i].aimed_force_n, others[i].aimed_force_n);
        // Before the contact there is nothing to feel, and so nothing that differs.
        EXPECT_TRUE(others[i].contact_s) << i;
        EXPECT_EQ(presented[i].contact_s, others[i].contact_s);
    }
}

TEST_P(TrialCondition, TracesWhatItPresents) {
    Scene scene = example_trial();
    scene.trial->object.least_breaking_force_n = 100;  // what breaks ends before the step of its last force
    scene.trial->object.breaking_force_n = 200;
    const Experiment experiment(scene, GetParam());
    const Presentation presented = experiment.present(3, 1).at(0);
    const std::vector<TraceStep> steps = experiment.trace(3);
    ASSERT_FALSE(steps.empty());
    double peak_n = 0;
    for (const TraceStep& step : steps) peak_n = std::max(peak_n, step.force_n);
    EXPECT_EQ(presented.outcome, Outcome::held);
    EXPECT_EQ(peak_n, presented.peak_force_n);
    const auto contact =
        std::find_if(steps.begin(), steps.end(), [](const auto& step) { return step.force_n > 0; });
    ASSERT_NE(contact, steps.end());
    EXPECT_EQ(contact->time_s, presented.contact_s.value());
}

INSTANTIATE_TEST_SUITE_P(Trial, TrialCondition, testing::ValuesIn(condition_names()),
                         [](const auto& name) { return name.param; });

TEST(Experiment, BreaksWhatIsPressedHarderThanItBears) {
    for (const char* name : {"none", "rate"}) {
        const auto presented = Experiment(example_trial(), name).present(0, 60);
        for (const Presentation& each : presented) {
            const bool too_hard = each.breaking_force_n && each.peak_force_n > *each.breaking_force_n;
            EXPECT_EQ(each.outcome == Outcome::broken, too_hard);
            EXPECT_EQ(each.broken_s.has_value(), too_hard);
        }
        EXPECT_GT(number_of(Outcome::held, presented), 30U);
        EXPECT_GT(number_of(Outcome::broken, presented), 3U);
    }
}

// A contact is answered in the step from which on the command is lower than what the EMG asks for.
TEST(Experiment, TellsWhenTheCommandAnswersTheContact) {
    const Experiment experiment(example_trial(), "rate");
    std::size_t answered = 0;
    for (std::uint32_t number = 0; number < 6; ++number) {
        const Presentation presented = experiment.present(number, 1).at(0);
        std::optional<double> expected_s;
        for (const TraceStep& step : experiment.trace(number))
            // Nobody opens the hand: the opening effort is that of an electrode at rest.
            if (!expected_s && presented.contact_s && step.time_s >= *presented.contact_s && step.gain < 0.95)
                expected_s = step.time_s - *presented.contact_s;
        if (!presented.answer_s) continue;
        ASSERT_TRUE(expected_s) << number;
        // The gain is 5 % lower a few steps after the command is lower by 0.01.
        EXPECT_NEAR(*presented.answer_s, *expected_s, 0.02) << number;
        EXPECT_GE(*presented.answer_s, 0.03) << "the radio alone takes an interval";
        ++answered;
    }
    EXPECT_GT(answered, 3U);
    for (const Presentation& each : Experiment(example_trial(), "none").present(0, 6))
        EXPECT_FALSE(each.answer_s);
}

// It is told of a contact by the first sample that is above the noise before the contact.
TEST(Experiment, TellsWhenTheHandIsToldOfTheContact) {
    const Experiment experiment(example_trial(), "force");
    for (std::uint32_t number = 0; number < 6; ++number) {
        const Presentation presented = experiment.present(number, 1).at(0);
        ASSERT_TRUE(presented.contact_s && presented.told_s) << number;
        double highest_n = 0;
        std::optional<double> expected_s;
        for (const TraceStep& step : experiment.trace(number)) {
            if (step.time_s < *presented.contact_s)
                highest_n = std::max(highest_n, step.estimate_n);
            else if (!expected_s && step.estimate_n > highest_n)
                expected_s = step.time_s - *presented.contact_s;
        }
        EXPECT_GT(highest_n, 0) << "sensors have noise";
        EXPECT_EQ(presented.told_s, expected_s) << number;
    }
    for (const Presentation& each : Experiment(example_trial(), "rate").present(0, 6)) {
        ASSERT_TRUE(each.told_s);
        EXPECT_GE(*each.told_s, 0.03) << "the radio alone takes an interval";
        EXPECT_LE(*each.told_s, each.answer_s.value_or(10));
    }
    for (const Presentation& each : Experiment(example_trial(), "none").present(0, 6))
        EXPECT_FALSE(each.told_s);
}

// A gain that is low before anything is touched is no answer.
TEST(Experiment, IsNotAnsweredByAGainThatWasLowBefore) {
    Scene scene = example_trial();
    scene.gain.onset_n = 0;
    scene.gain.upper_bound_sigmas = 3;
    const Experiment experiment(scene, "exponential");
    std::size_t answered = 0;
    for (std::uint32_t number = 0; number < 6; ++number) {
        const std::vector<TraceStep> steps = experiment.trace(number);
        const Presentation presented = experiment.present(number, 1).at(0);
        ASSERT_TRUE(presented.contact_s) << number;
        const auto contact = std::ranges::find_if(
            steps, [&](const TraceStep& step) { return step.time_s >= *presented.contact_s; });
        ASSERT_NE(contact, steps.begin());
        EXPECT_LT(std::prev(contact)->gain, 0.95) << "it was to be low before";
        if (!presented.answer_s) continue;
        EXPECT_GE(*presented.answer_s, 0.03) << "the radio alone takes an interval";
        ++answered;
    }
    EXPECT_GT(answered, 3U);
}

TEST(Experiment, FeelsWhatTheSensingSaysAndNotWhatTheDecoderIsTold) {
    Scene dead = example_trial();
    dead.trial->sensing.dead_elements = 9;
    const auto without = Experiment(example_trial(), "none").present(0, 6);
    const auto numb = Experiment(dead, "force").present(0, 6);
    ASSERT_EQ(numb.size(), without.size());
    // A hand that feels nothing does as one without feedback.
    for (std::size_t i = 0; i < numb.size(); ++i) EXPECT_EQ(numb[i].peak_force_n, without[i].peak_force_n);
    Scene gains = example_trial();
    gains.trial->sensing.gain_spread = 0.5;
    EXPECT_NE(Experiment(gains, "force").present(0, 6), Experiment(example_trial(), "force").present(0, 6));
}

TEST(Experiment, HasUsersWhoPressOnWhereTheGainIsLow) {
    Scene scene = example_trial();
    scene.gain.onset_n = 0;
    scene.trial->slippery.part = 1;  // nothing breaks
    const auto as_meant = Experiment(scene, "force").present(0, 12);
    scene.trial->user.press_on = 5;
    const auto pressed = Experiment(scene, "force").present(0, 12);
    ASSERT_EQ(pressed.size(), as_meant.size());
    std::size_t harder = 0;
    for (std::size_t i = 0; i < pressed.size(); ++i)
        harder += pressed[i].peak_force_n > as_meant[i].peak_force_n + 0.1;
    EXPECT_GT(harder, 6U);
}

TEST(Experiment, BreaksFewerWithFeedback) {
    const auto without = Experiment(example_trial(), "none").present(0, 120);
    const auto with = Experiment(example_trial(), "force").present(0, 120);
    // Some 26 of 96 delicate objects break without feedback and 13 with it. Both have the same users, objects
    // and noise, so that hardly any object breaks with feedback alone.
    EXPECT_LT(number_of(Outcome::broken, with) + 5, number_of(Outcome::broken, without));
}

TEST(Experiment, LeavesTheGainAloneWithoutFeedback) {
    const std::vector<TraceStep> steps = Experiment(example_trial(), "none").trace(0);
    ASSERT_GT(steps.size(), 1000U);
    for (const TraceStep& step : steps) {
        ASSERT_EQ(step.gain, 1);
        ASSERT_EQ(step.estimate_n, 0);
    }
}

// The forces of the samples that can be in the hand at a step were there between two times before it: at most
// the samples' interval, two connections and a packet ago, and at least one connection.
void expect_delayed_forces(double interval_ms) {
    Scene scene = with_ideal_sensors();
    scene.trial->connection_interval_ms = interval_ms;
    const Experiment experiment(scene, "force");
    const double link_ms = scene.link.packet_ms + scene.link.delivery_ms + 1;
    const auto newest = static_cast<std::size_t>(interval_ms + scene.link.delivery_ms);
    const auto oldest = static_cast<std::size_t>(2 * interval_ms + 5 + link_ms);
    // Nine converters round to the nearest of 4096 steps.
    const double tolerance_n = 9 * 0.5 * 10.0 / 4095 + 1e-9;
    const std::vector<TraceStep> steps = experiment.trace(3);
    double highest_n = 0;
    for (std::size_t i = oldest; i < steps.size(); ++i) {
        const auto [low, high] =
            std::minmax_element(steps.begin() + static_cast<std::ptrdiff_t>(i - oldest),
                                steps.begin() + static_cast<std::ptrdiff_t>(i - newest + 1),
                                [](const auto& a, const auto& b) { return a.force_n < b.force_n; });
        ASSERT_GE(steps[i].estimate_n, low->force_n - tolerance_n) << steps[i].time_s;
        ASSERT_LE(steps[i].estimate_n, high->force_n + tolerance_n) << steps[i].time_s;
        highest_n = std::max(highest_n, steps[i].estimate_n);
    }
    EXPECT_GT(highest_n, 3);
}

TEST(Experiment, DelaysSamplesByOneToTwoConnections) { expect_delayed_forces(30); }
TEST(Experiment, HasSamplesAtOnceWithoutARadio) { expect_delayed_forces(0); }

TEST(Experiment, CountsForcesInOnsetAndOffsetEvents) {
    Scene scene = with_ideal_sensors();
    scene.trial->connection_interval_ms = 0;
    scene.trial->send_on_delta.delta_n = 0.05;
    const std::vector<TraceStep> steps = Experiment(scene, "send_on_delta").trace(3);
    ASSERT_FALSE(steps.empty());
    // Once the force is steady, each element's level is below its force by less than delta.
    const TraceStep& last = steps.back();
    EXPECT_GT(last.force_n, 3);
    EXPECT_LE(last.estimate_n, last.force_n + 9 * 0.5 * 10.0 / 4095);
    EXPECT_GT(last.estimate_n, last.force_n - 9 * (0.05 + 0.5 * 10.0 / 4095));
}

// Its changes are no spikes.
TEST(Experiment, CountsForcesAlikeWhereSpikesArePredicted) {
    Scene scene = with_ideal_sensors();
    scene.trial->connection_interval_ms = 0;
    const std::vector<TraceStep> steps = Experiment(scene, "send_on_delta").trace(3);
    scene.link.encoding = scene::Encoding::predicted;
    const std::vector<TraceStep> predicted = Experiment(scene, "send_on_delta").trace(3);
    ASSERT_FALSE(steps.empty());
    ASSERT_EQ(predicted.size(), steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i)
        ASSERT_EQ(predicted[i].estimate_n, steps[i].estimate_n) << i;
}

TEST(Experiment, DecodesTheSteadyForce) {
    // The estimates by inversion do not know adaptation; 5 % is what one interval of a neuron tells in the
    // worst case.
    const std::vector<TraceStep> steps = Experiment(with_ideal_sensors(), "inversion").trace(3);
    ASSERT_FALSE(steps.empty());
    EXPECT_NEAR(steps.back().estimate_n / steps.back().force_n, 1, 0.05);
}

TEST(Experiment, GoesSafeWhenNothingArrives) {
    Scene scene = example_trial();
    scene.link.channel = scene::Channel{.loss = 1};
    scene.trial->user.patience_s = 1;
    for (const char* name : {"force", "rate", "send_on_delta"}) {
        const std::vector<Presentation> presented = Experiment(scene, name).present(0, 4);
        EXPECT_EQ(presented.size(), 4U) << name;
        for (const Presentation& each : presented) {
            EXPECT_TRUE(each.safe_state) << name;
            // A hand that may not close reaches nothing.
            EXPECT_FALSE(each.contact_s) << name;
            EXPECT_EQ(each.outcome, Outcome::dropped) << name;
        }
    }
    EXPECT_FALSE(Experiment(scene, "none").present(0, 1).at(0).safe_state) << "it has no link";
}

// The radio's connections are rarer than the link may be silent; the link has its heartbeat.
TEST(Experiment, StaysInOperationBetweenRareConnections) {
    Scene scene = example_trial();
    scene.trial->connection_interval_ms = 200;
    scene.trial->user.reach_effort = 0.05;  // no contact
    scene.trial->user.patience_s = 1;
    for (const char* name : {"force", "rate", "send_on_delta"}) {
        const std::vector<TraceStep> steps = Experiment(scene, name).trace(0);
        ASSERT_GT(steps.size(), 1000U) << name;
        for (const TraceStep& step : steps) ASSERT_EQ(step.gain, 1) << name;
    }
}

TEST(Experiment, DropsWhatIsNotGrippedOrSlipsAway) {
    Scene weak = example_trial();
    weak.trial->user.reach_effort = 0.05;  // within the motor's dead band
    weak.trial->user.reach_spread = 0;
    weak.trial->user.patience_s = 1;
    EXPECT_EQ(number_of(Outcome::dropped, Experiment(weak, "none").present(0, 5)), 5U);

    Scene heavy = example_trial();
    heavy.trial->slippery.weight_n = 40;  // takes 50 N, and the hand has 26.5
    heavy.trial->slippery.weight_spread = 0;
    const std::vector<Presentation> fallen = all_slippery(heavy, "none", 5);
    EXPECT_EQ(fallen.size(), 5U);
    for (const Presentation& each : fallen) {
        EXPECT_EQ(each.outcome, Outcome::dropped);
        ASSERT_TRUE(each.slip_onset_s && each.dropped_s);
        EXPECT_GT(*each.dropped_s, *each.slip_onset_s);
        EXPECT_FALSE(each.slip_reaction_s) << "nothing feels it";
        EXPECT_LT(2 * heavy.trial->slippery.friction * each.held_force_n, each.weight_n);
    }
    Scene light = example_trial();
    light.trial->slippery.weight_n = 0.1;
    EXPECT_EQ(number_of(Outcome::held, all_slippery(light, "none", 5)), 5U);
}

TEST(Experiment, TellsWhenTheGainAnswersASlip) {
    Scene scene = example_trial();
    scene.trial->connection_interval_ms = 0;
    scene.trial->slippery.weight_n = 12;
    scene.trial->slippery.taper = 1;  // so that there is much to feel
    std::size_t reactions = 0;
    for (const Presentation& each : all_slippery(scene, "force", 20)) {
        if (!each.slip_reaction_s) continue;
        ++reactions;
        EXPECT_GT(*each.slip_reaction_s, 0);
        EXPECT_LT(each.slip_onset_s.value() + *each.slip_reaction_s, each.dropped_s.value_or(10));
    }
    EXPECT_GT(reactions, 5U);
}

// Objects of 3 N in a hand that holds them as it would a cracker.
TEST(Experiment, HoldsWithAPulseWhatWouldFall) {
    Scene scene = example_trial();
    scene.trial->connection_interval_ms = 0;
    scene.trial->slippery.aim_factor = 1;
    scene.gain.lambda_n = 8;
    scene.decoder.kind = scene::Filter();
    const std::vector<Presentation> without = all_slippery(scene, "force", 60);
    const std::size_t fell = number_of(Outcome::dropped, without);
    EXPECT_GT(fell, 3U);
    for (const Presentation& each : without) EXPECT_EQ(each.false_pulses, 0U);
    scene.gain.pulse.emplace().fall_n = 0.05;
    const std::vector<Presentation> with = all_slippery(scene, "force", 60);
    EXPECT_LE(number_of(Outcome::dropped, with), fell / 3);
    std::size_t stopped = 0;
    for (const Presentation& each : with) {
        EXPECT_EQ(each.false_pulses, 0U) << each.number;
        if (!each.slip_onset_s || each.outcome != Outcome::held) continue;
        ++stopped;
        EXPECT_GT(each.slipped_mm, 0);
        EXPECT_LT(each.slip_reaction_s.value(), 0.3);
    }
    EXPECT_GT(stopped, 3U);
    const std::vector<Presentation> rate = all_slippery(scene, "rate", 10);
    for (const Presentation& each : rate) EXPECT_EQ(each.false_pulses, 0U) << "rate takes no pulse";
}

// Packets that are lost or late leave a silence, which is no fall of the force.
TEST(Experiment, DoesNotPulseWherePacketsAreMissing) {
    Scene scene = example_trial();
    scene.trial->connection_interval_ms = 0;
    scene.trial->slippery.part = 0;
    scene.gain.pulse.emplace();
    scene.decoder.kind = scene::Filter();
    for (const scene::Channel& channel : {scene::Channel{.loss = 0.1}, scene::Channel{.jitter_ms = 20}}) {
        scene.link.channel = channel;
        std::uint32_t false_pulses = 0;
        for (const Presentation& each : Experiment(scene, "filter").present(0, 30))
            false_pulses += each.false_pulses;
        EXPECT_LE(false_pulses, 1U);
    }
}

TEST(Experiment, StopsWhenToldTo) {
    const Experiment experiment(example_trial(), "none");
    std::vector<std::uint32_t> told;
    const auto some = experiment.present(0, 500, [&](std::uint32_t done) {
        told.push_back(done);
        return told.size() < 2;
    });
    ASSERT_EQ(told.size(), 2U);
    EXPECT_EQ(some.size(), told.back());
    EXPECT_LT(some.size(), 500U);
    EXPECT_EQ(experiment.present(0, told.back()), some);
    EXPECT_TRUE(experiment.present(0, 0).empty());
}

std::string refusal(const Scene& scene, std::string_view condition) {
    try {
        (void)Experiment(scene, condition);
    } catch (const SceneError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(Experiment, SaysWhatIsWrong) {
    EXPECT_EQ(refusal(example_trial(), "rat"), "condition: there is no \"rat\": did you mean \"rate\"?");
    Scene bare = example_trial();
    bare.trial.reset();
    EXPECT_NE(refusal(bare, "rate").find("trial is missing"), std::string::npos);
    Scene without_packets = example_trial();
    without_packets.link = {};
    EXPECT_NE(refusal(without_packets, "rate").find("link must be one that carries packets"),
              std::string::npos);
    Scene wrong = example_trial();
    wrong.trial->user.aim_n = -1;
    EXPECT_NE(refusal(wrong, "none").find("trial.user.aim_n must be > 0"), std::string::npos);
}

TEST(Conditions, KeepTheScenesOwnDecoderWhereItIsTheSame) {
    Scene scene = example_trial();
    scene.decoder.kind = scene::SlidingWindow{.window_ms = 80};
    EXPECT_EQ(condition("rate").applied_to(scene).decoder, scene.decoder);
    EXPECT_TRUE(std::holds_alternative<scene::Filter>(condition("filter").applied_to(scene).decoder.kind));
    scene.decoder.kind = scene::Filter();
    EXPECT_EQ(std::get<scene::SlidingWindow>(condition("rate").applied_to(scene).decoder.kind).window_ms, 60);
}

// Closing EMG that alternates around its rest, so that its envelope is `effort` from 0.2 s on.
class RecordedEmg : public testing::Test {
  protected:
    void SetUp() override { std::filesystem::create_directory(folder_); }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    Scene scene(double effort, double length_s = 4) const {
        std::ofstream table(folder_ / "emg.csv");
        table << "time_s,emg\n";
        const int half = static_cast<int>(std::lround(500 * effort));
        for (int k = 0; k < 1000 * length_s; ++k)
            table << k / 1000.0 << ',' << 1900 + (k < 200 ? 0 : k % 2 ? half : -half) << '\n';
        Scene scene = example_trial();
        scene.folder = folder_;
        scene.hand.emg_table = scene::EmgTable{.path = "emg.csv", .rest_counts = 1900.0};
        return scene;
    }

  private:
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("afferent_trial_" + std::to_string(getpid()));
};

TEST_F(RecordedEmg, MovesTheHandInPlaceOfTheUser) {
    constexpr std::uint32_t count = 20;
    EXPECT_EQ(number_of(Outcome::dropped, Experiment(scene(0), "none").present(0, count)), count)
        << "a muscle at rest grips nothing";
    const auto gripped = Experiment(scene(0.5), "none").present(0, count);
    // Without feedback a held effort ends at its part of the largest force, whoever the user is; a stiff
    // object is hit harder than that, and the motor does not give way.
    const double largest_n = example_trial().trial->motor.force_limit_n;
    for (const Presentation& each : gripped) {
        if (each.outcome == Outcome::held) {
            EXPECT_GT(each.held_force_n, 0.49 * largest_n);
        }
    }
    EXPECT_GT(number_of(Outcome::held, gripped), 0U);
    EXPECT_GT(number_of(Outcome::broken, gripped), count / 4) << "most break at less than 13 N";
    // Each begins with the recording's first row, whatever came before.
    const Experiment again(scene(0.5), "rate");
    EXPECT_EQ(again.present(7, 1).at(0), again.present(0, 8).at(7));
}

TEST_F(RecordedEmg, EndsTheWaitForAContact) {
    const auto presented = Experiment(scene(0, 1.5), "none").present(0, 1);
    EXPECT_NEAR(presented.at(0).dropped_s.value(), 1.5, 2e-3);
}

TEST_F(RecordedEmg, ThatCannotBeReadIsNamed) {
    Scene missing = scene(0.5);
    missing.hand.emg_table->path = "no.csv";
    try {
        Experiment(missing, "none");
        FAIL();
    } catch (const SceneError& error) {
        EXPECT_NE(std::string(error.what()).find("no.csv"), std::string::npos) << error.what();
    }
}

// Without the brake a tenth of these objects breaks on impact; the brake also holds where the motor's time
// constant is 30 % off either way. Of 160 objects: three binomial standard deviations of 2 % are 5 of them.
TEST(ContactBrake, LetsFewerObjectsBreakByWhateverTellsOfTheContact) {
    Scene scene = Scene::from_file(std::string(AFFERENT_SOURCE_DIR) + "/examples/trial_in_hand.txtpb");
    scene.runtime.threads = 1;
    scene.trial->slippery.part = 0;
    const auto broken = [&](const char* condition) {
        return number_of(Outcome::broken, Experiment(scene, condition).present(0, 160));
    };
    for (const char* condition : {"force", "rate"}) {
        for (const double told_ms : {28.0, 40.0, 52.0}) {
            if (!long_runs && told_ms != 52) continue;
            scene.hand.motor.time_constant_ms = told_ms;
            EXPECT_LE(broken(condition), 8U) << condition << ", told " << told_ms << " ms";
        }
        const auto brake = std::exchange(scene.gain.brake, std::nullopt);
        EXPECT_GE(broken(condition), 9U) << condition;
        scene.gain.brake = brake;
    }
}

}  // namespace
}  // namespace afferent
