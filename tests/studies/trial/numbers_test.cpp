#include "afferent/studies/trial/numbers.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "afferent/studies/trial/ablations.hpp"
#include "afferent/studies/trial/experiment.hpp"
#include "tests/studies/trial/example_trial.hpp"

namespace afferent {
namespace {

TEST(TrialNumbers, HaveAllThatIsInTheSceneWithinTheirPlausibleRanges) {
    const Scene scene = example_trial();
    std::set<std::string_view> paths;
    for (const TrialNumber& number : trial_numbers()) {
        EXPECT_TRUE(paths.insert(number.path).second) << number.path;
        EXPECT_LE(number.low, value_in(scene, number)) << number.path;
        EXPECT_GE(number.high, value_in(scene, number)) << number.path;
        EXPECT_LT(number.low, number.high) << number.path;
        EXPECT_FALSE(number.source.empty()) << number.path;
        EXPECT_EQ(find_trial_number(number.path), &number);
    }
    EXPECT_GT(paths.size(), 20U);
    EXPECT_EQ(find_trial_number("trial.user"), nullptr);
}

TEST(TrialNumbers, CanBeSetToEitherEnd) {
    const Scene scene = example_trial();
    for (const TrialNumber& number : trial_numbers())
        for (const double value : {number.low, number.high}) {
            const Scene changed = with_number(scene, number, value);
            EXPECT_EQ(value_in(changed, number), value) << number.path;
            EXPECT_NO_THROW(changed.check()) << number.path;
            // It is the number of that path and no other: its text is how the scene differs.
            const std::string_view field = number.path.substr(number.path.rfind('.') + 1);
            const bool is_told = changed.text().find(field) != std::string::npos;
            EXPECT_TRUE(is_told || value == value_in(Scene(), number)) << number.path;
            for (const TrialNumber& other : trial_numbers()) {
                if (other.path == number.path) continue;
                EXPECT_EQ(value_in(changed, other), value_in(scene, other)) << other.path;
            }
        }
}

TEST(TrialNumbers, OfTheGainAreThoseOfEachConditionToo) {
    Scene scene = example_trial();
    scene.trial->conditions = {{"rate", scene.gain}, {"force", std::nullopt}};
    scene.trial->conditions[0].gain->onset_n = 1;
    const TrialNumber& lambda = *find_trial_number("gain.lambda_n");
    const Scene changed = with_number(scene, lambda, 7);
    EXPECT_EQ(changed.gain.lambda_n, 7);
    ASSERT_EQ(changed.trial->conditions.size(), 2U);
    EXPECT_EQ(changed.trial->conditions[0].gain.value().lambda_n, 7);
    EXPECT_EQ(changed.trial->conditions[0].gain->onset_n, 1);
    EXPECT_FALSE(changed.trial->conditions[1].gain);
    EXPECT_EQ(with_number(scene, *find_trial_number("trial.user.aim_n"), 5).trial->conditions[0].gain,
              scene.trial->conditions[0].gain);
}

TEST(TrialNumbers, StandInTheDocumentWithTheirSource) {
    std::ifstream in(AFFERENT_SOURCE_DIR "/docs/trial.md");
    const std::string document(std::istreambuf_iterator<char>(in), {});
    for (const TrialNumber& number : trial_numbers()) {
        const std::size_t row = document.find("| `" + std::string(number.path) + "` |");
        ASSERT_NE(row, std::string::npos) << number.path;
        const std::string line = document.substr(row, document.find('\n', row) - row);
        EXPECT_NE(line.find(std::string(number.source)), std::string::npos) << line;
    }
}

TEST(Ablations, TakeOutOrAddWhatTheySay) {
    const Scene scene = example_trial();
    for (const char* const name : {"no_adaptation", "one_neuron", "transient_added"})
        ASSERT_NE(find_ablation(name), nullptr) << name;
    const Scene plain = find_ablation("no_adaptation")->applied(scene, "rate");
    for (const scene::Patch& patch : plain.patches) EXPECT_EQ(patch.neuron.delta_g, 0);
    const Plan one = make_plan(find_ablation("one_neuron")->applied(scene, "rate"));
    EXPECT_EQ(one.addresses, 1U);
    const Experiment both(find_ablation("transient_added")->applied(scene, "filter"), "filter");
    EXPECT_EQ(both.plan().addresses, 2 * make_plan(scene).addresses);
    EXPECT_EQ(both.plan().elements, make_plan(scene).elements);
    EXPECT_EQ(find_ablation("nothing"), nullptr);
}

// Fails where an ablation leaves the chain as it was.
TEST(Ablations, ChangeWhatTheHandDoes) {
    const Scene scene = example_trial();
    ASSERT_FALSE(ablations().empty());
    for (const Ablation& ablation : ablations())
        for (const std::string& condition : ablation.conditions) {
            const auto whole = Experiment(scene, condition).trace(0);
            const auto ablated = Experiment(ablation.applied(scene, condition), condition).trace(0);
            double apart = 0;
            for (std::size_t i = 0; i < std::min(whole.size(), ablated.size()); ++i)
                apart = std::max(apart, std::abs(whole[i].estimate_n - ablated[i].estimate_n));
            EXPECT_GT(apart, 0.01) << ablation.name << ", " << condition;
        }
}

}  // namespace
}  // namespace afferent
