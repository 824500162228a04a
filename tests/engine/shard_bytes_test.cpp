// What the plan says of a shard's memory, against the shard itself.
#include "afferent/scene/shard_bytes.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/engine/make_shard.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// Each form, each neuron, alike and different, with and without adaptation, periods and rows of weights.
TEST(ShardBytes, AreThoseOfTheShardThatIsBuilt) {
    const std::string spread = "spread { gain { normal { sd: 0.1 } } threshold { normal { sd: 0.1 } } } ";
    for (const std::string& patch : std::initializer_list<std::string>{
             "", "elements: 1", "elements: 3000", "elements: 3000 neuron { delta_g: 0 }",
             "elements: 3000 neuron { refractory_ms: 2 }", "kind: SA1 outline {}", "kind: RA outline {}",
             "kind: PC outline {} sensor { rate_hz: 1000 }", "kind: SA1_DYNAMIC outline {}",
             "kind: RA outline {} encoder { transient { negative_ratio: 0.5 threshold_n_per_s: 1 } }",
             "outline {} afferents { per_cm2: 900 } " + spread,
             "outline {} afferents { per_cm2: 900 } neuron { delta_g: 0 refractory_ms: 1 } " + spread,
             "neuron { fixed_point {} }"})
        for (const std::string& form : {std::string("AUTO"), std::string("SPARSE"), std::string("DENSE")}) {
            if (patch.find("fixed_point") != std::string::npos && form == "DENSE") continue;
            const std::string text = "patch { name: 'a' " + patch +
                                     " } source { profile { point { force_n: 1 } } } " +
                                     "record { force: false picture: false }";
            SCOPED_TRACE(text + form);
            const Plan plan =
                make_plan(Scene::from_text(text).with(std::vector<Setting>{{"neuron.form", form}}));
            ASSERT_FALSE(plan.shards.empty());
            for (const Plan::ShardPlan& each : plan.shards) {
                const PatchPlan& of = plan.patches[each.patch];
                const std::size_t built =
                    make_shard(of, each.begin, each.count, plan.scene.runtime.spikes_per_window)->bytes();
                EXPECT_NEAR(static_cast<double>(shard_bytes(of, each.begin, each.count)),
                            static_cast<double>(built), 2 * sizeof(void*));
            }
        }
}

TEST(ShardBytes, OfACoprocessorAreTheSumOfItsShards) {
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'a' elements: 300 } patch { name: 'b' elements: 500 neuron { delta_g: 0 } } "
        "source { profile { point { force_n: 1 } } } record { force: false picture: false }"));
    std::size_t sum = 0;
    for (const Plan::ShardPlan& each : plan.shards)
        sum += shard_bytes(plan.patches[each.patch], each.begin, each.count);
    ASSERT_GE(plan.shards.size(), 2U);
    EXPECT_NEAR(static_cast<double>(Coprocessor(plan).bytes()), static_cast<double>(sum),
                2.0 * sizeof(void*) * static_cast<double>(plan.shards.size()));
}

}  // namespace
}  // namespace afferent
