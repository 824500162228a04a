#include "afferent/nodes/hello.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

Result<LinkAddress> address(const std::string& link, bool lockstep) {
    return address_of(make_plan(Scene::from_text("link { " + link + " }")), LinkEnd::hand, lockstep);
}

TEST(AddressOf, ALinkInLockstepLosesNothing) {
    EXPECT_TRUE(address("tcp {}", true));
    EXPECT_TRUE(address("udp {}", false));
    EXPECT_TRUE(address("tcp {} channel { latency_ms: 1 }", false));
    for (const std::string link : {"udp {}", "tcp {} channel { latency_ms: 1 }"}) {
        const auto refused = address(link, true);
        ASSERT_FALSE(refused) << link;
        EXPECT_EQ(refused.error().kind, Error::Kind::not_allowed);
        EXPECT_NE(refused.error().text.find("--lockstep waits for every message"), std::string::npos);
    }
}

TEST(AddressOf, IsThatOfTwoProcesses) {
    for (const std::string link : {"in_process {}", "file { path: \"a.events\" }"}) {
        const auto refused = address(link, false);
        ASSERT_FALSE(refused) << link;
        EXPECT_EQ(refused.error().kind, Error::Kind::not_allowed);
    }
}

TEST(Hello, TellsThePatchesAndTheNeuronsOfEach) {
    const proto::Hello hello =
        make_hello(make_plan(Scene::from_text(
                       "link { tcp {} } patch { name: 'a' elements: 3 } patch { name: 'b' elements: 2 "
                       "neuron { tau_m_ms: 7 delta_g: 0.25 } }")),
                   false);
    EXPECT_EQ(hello.addresses(), 5U);
    ASSERT_EQ(hello.patch_size(), 2);
    EXPECT_EQ(hello.patch(0).name(), "a");
    EXPECT_EQ(hello.patch(0).first(), 0U);
    EXPECT_EQ(hello.patch(0).count(), 3U);
    EXPECT_EQ(hello.patch(1).first(), 3U);
    EXPECT_EQ(hello.patch(1).count(), 2U);
    EXPECT_EQ(hello.patch(1).neuron().tau_m_ms(), 7);
    EXPECT_EQ(hello.patch(1).neuron().delta_g(), 0.25);
}

TEST(Hello, TellsWhatEncodersRectifyAndAdd) {
    const proto::Hello hello = make_hello(
        make_plan(Scene::from_text(
            "link { tcp {} } patch { name: 'a' encoder { transient { gain_mv_s_per_n: 2 corner_hz: 40 "
            "negative_ratio: 0 threshold_n_per_s: 0.5 } } } "
            "patch { name: 'b' encoder { sustained { gain_mv_per_n: 3 dynamic { time_ms: 30 corner_hz: 20 } "
            "slow_adaptation { time_s: 6 part: 0.25 } } } } "
            "patch { name: 'c' encoder { transient { gain_mv_s_per_n: 4 } } } decoder { patch: 'd' } "
            "patch { name: 'd' }")),
        false);
    ASSERT_EQ(hello.patch_size(), 4);
    const proto::NeuronDescription& half = hello.patch(0).neuron();
    EXPECT_EQ(half.gain_mv_s_per_n(), 2);
    EXPECT_EQ(half.corner_hz(), 40);
    EXPECT_TRUE(half.has_negative_ratio());
    EXPECT_EQ(half.negative_ratio(), 0);
    EXPECT_EQ(half.threshold(), 0.5);
    const proto::NeuronDescription& dynamic = hello.patch(1).neuron();
    EXPECT_EQ(dynamic.gain_mv_per_n(), 3);
    EXPECT_EQ(dynamic.dynamic_time_ms(), 30);
    EXPECT_EQ(dynamic.corner_hz(), 20);
    EXPECT_EQ(dynamic.slow_part(), 0.25);
    EXPECT_EQ(dynamic.slow_time_s(), 6);
    const proto::NeuronDescription& full = hello.patch(2).neuron();
    EXPECT_FALSE(full.has_negative_ratio());
    EXPECT_EQ(full.threshold(), 0);
    EXPECT_EQ(full.corner_hz(), 0);
    EXPECT_EQ(full.dynamic_time_ms(), 0);
    EXPECT_EQ(full.slow_part(), 0);
}

}  // namespace
}  // namespace afferent
