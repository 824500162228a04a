// Where the neurons of a scene begin.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// Without adaptation v approaches v_r + R·I along an exponential, from wherever it begins.
TEST(Phases, AreThoseOfTheirAddressesInEveryShardAndAgainAfterAReset) {
    for (const std::string form : {"SPARSE", "DENSE", "AUTO"}) {
        const Plan plan = make_plan(Scene::from_text(
            "every_patch { encoder { sustained { gain_mv_per_n: 40 } } neuron { delta_g: 0 form: " + form +
            " } spread { phase { uniform { lowest: 0.1 highest: 0.9 } } } } "
            "patch { name: 'a' elements: 2500 } patch { name: 'b' elements: 7 } "
            "source { profile { point {} } } record { force: false picture: false }"));
        ASSERT_GE(plan.shards.size(), 4U);
        const LifParameters neuron;
        const double gap_mv = neuron.v_th_mv - neuron.v_r_mv;
        const double drive_mv = 2 * gap_mv;
        const std::vector<double> forces_n(plan.elements, drive_mv / 40);
        Coprocessor coprocessor(plan);
        for (int repeated = 0; repeated < 2; ++repeated) {
            coprocessor.push({scene_start, 0, forces_n});
            std::map<Address, double> first_ms;
            for (const Event& event : coprocessor.advance(scene_start + 10ms))
                first_ms.try_emplace(event.address, 1e3 * seconds(event.time - scene_start));
            ASSERT_EQ(first_ms.size(), plan.addresses);
            for (const PatchPlan& patch : plan.patches)
                for (std::uint32_t i = 0; i < patch.afferents(); ++i)
                    EXPECT_NEAR(first_ms.at(patch.first + i),
                                neuron.tau_m_ms *
                                    std::log((drive_mv - patch.phases(i) * gap_mv) / (drive_mv - gap_mv)),
                                2e-6)
                        << form << ", " << patch.name << ", " << i;
            coprocessor.reset();
        }
    }
}

}  // namespace
}  // namespace afferent
