#include "afferent/decoders/afferent_builder.hpp"

#include <gtest/gtest.h>

#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

// Groups alike and unlike, among them two that differ in their neurons only.
std::vector<DecodedAfferents::Group> some_groups() {
    std::vector<DecodedAfferents::Group> groups{group_with(2), group_with(4), group_with(2), group_with(0)};
    groups.push_back(groups[0]);
    std::get<LifParameters>(groups.back().neuron).delta_g = 0.5;
    groups.push_back(groups[0]);
    groups.back().full_scale_n = 10;
    groups.push_back(groups[4]);
    return groups;
}

TEST(Uncertainty, HasTheDefaultsOfAScene) {
    EXPECT_EQ(Uncertainty(), (Uncertainty{.gain = 0.05,
                                          .common_gain = 0.01,
                                          .share = 0.05,
                                          .share_time_s = 2,
                                          .offset_n = 0,
                                          .hysteresis = 0.01,
                                          .adaptation = 0}));
}

TEST(AfferentBuilder, AddsWhatAddAdds) {
    DecodedAfferents one_by_one = fingertips();
    DecodedAfferents built = fingertips();
    AfferentBuilder builder(built);
    Address address = 5;
    for (const DecodedAfferents::Group& group : some_groups()) {
        one_by_one.add(address, group, 0.1);
        builder.add(address, group, 0.1);
        ++address;
    }
    EXPECT_EQ(built, one_by_one);
    EXPECT_EQ(built.groups.size(), 5U) << "the neuron and the full scale differ";
}

// Comparing each of them with all others would take a minute.
TEST(AfferentBuilder, AddsAHundredThousandGroups) {
    constexpr Address groups = 100'000;
    DecodedAfferents afferents;
    AfferentBuilder builder(afferents);
    const DecodedAfferents::Group first = group_with(2);
    for (Address address = 0; address < 2 * groups; ++address) {
        DecodedAfferents::Group group = first;
        group.drive_mv_per_n = 2 + 1e-6 * (address % groups);
        builder.add(address, group, 1e-6);
    }
    ASSERT_EQ(afferents.groups.size(), groups);
    for (Address address = 0; address < 2 * groups; ++address)
        ASSERT_EQ(afferents.afferents[address].group, address % groups);
}

}  // namespace
}  // namespace afferent
