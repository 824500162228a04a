#include "afferent/nodes/ranks/share.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "afferent/scene/scene.hpp"

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

struct Sampling {
    bool any;
    ElementRange sampled;
    ElementRange counted;

    friend bool operator==(const Sampling&, const Sampling&) = default;
};

// What each rank does of the first patch.
std::vector<Sampling> sampling(const Plan& plan, const std::vector<std::size_t>& boundaries,
                               bool first_samples_all = false) {
    std::vector<Sampling> found;
    for (std::size_t rank = 0; rank + 1 < boundaries.size(); ++rank) {
        Plan own = plan;
        share_sampling(own, boundaries, rank, first_samples_all);
        const PatchPlan& patch = own.patches.front();
        found.push_back({patch.owns_elements, patch.sampled, patch.counted});
    }
    return found;
}

// Four shards of 25 afferents that read so many elements.
Plan plan_of_four_shards(std::uint32_t elements, const ReceptiveFields& fields) {
    Plan plan = make_plan(Scene::from_text("every_patch { elements: " + std::to_string(elements) +
                                           " } duration_s: 1 source { profile { point { force_n: 1 } } }"));
    plan.patches.front().fields = fields;
    const Plan::ShardPlan shard = plan.shards.front();
    plan.shards.clear();
    for (std::uint32_t i = 0; i < 4; ++i) {
        plan.shards.push_back(shard);
        plan.shards.back().begin = 25 * i;
        plan.shards.back().count = 25;
    }
    return plan;
}

TEST(Share, SamplesThoseElementsOfAPatchThatARankReads) {
    const Plan plan = plan_of_four_shards(100, ReceptiveFields::one_each(100));
    EXPECT_EQ(sampling(plan, {0, 1, 4}),
              (std::vector<Sampling>{{true, {0, 25}, {0, 25}}, {true, {25, 100}, {25, 100}}}));
    EXPECT_EQ(sampling(plan, {0, 2, 2, 4}),
              (std::vector<Sampling>{
                  {true, {0, 50}, {0, 50}}, {false, {0, 100}, {0, 100}}, {true, {50, 100}, {50, 100}}}));
    // The clock of the run takes a patch.
    EXPECT_EQ(sampling(plan, {0, 0, 4}),
              (std::vector<Sampling>{{true, {0, 100}, {0, 100}}, {true, {0, 100}, {100, 100}}}));
    EXPECT_EQ(sampling(plan, {0, 2, 4}, true),
              (std::vector<Sampling>{{true, {0, 100}, {0, 100}}, {true, {50, 100}, {100, 100}}}));
}

// Afferent i reads the elements i and i + 12. Nobody reads the last eight of the 120 elements.
TEST(Share, CountsEachSampleOnce) {
    FieldRows rows;
    for (std::uint32_t i = 0; i < 100; ++i) rows.add_row(std::array<FieldWeight, 2>{{{i, 1}, {i + 12, 1}}});
    const Plan plan = plan_of_four_shards(120, ReceptiveFields(120, std::move(rows)));
    EXPECT_EQ(sampling(plan, {0, 1, 3, 4}),
              (std::vector<Sampling>{
                  {true, {0, 37}, {0, 37}}, {true, {25, 87}, {37, 87}}, {true, {75, 120}, {87, 120}}}));
}

}  // namespace
}  // namespace afferent::ranks
