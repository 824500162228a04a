#include "afferent/io/wire/handshake.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

proto::Hello hello_with_a_patch() {
    proto::Hello hello;
    describe(PacketLayout{.addresses = 9}, hello);
    hello.set_scene_fingerprint(0x1234abcd);
    hello.set_nonce(7);
    hello.set_freeze_ms(60);
    hello.set_safe_ms(150);
    auto* patch = hello.add_patch();
    patch->set_name("thumb");
    patch->set_count(9);
    patch->mutable_neuron()->set_tau_m_ms(10);
    return hello;
}

std::string after(void (*change)(proto::Hello&)) {
    proto::Hello theirs = hello_with_a_patch();
    change(theirs);
    return disagreement(theirs, hello_with_a_patch()).value_or("agreed");
}

TEST(Handshake, AgreesOnEqualHellosWhateverTheNonce) {
    EXPECT_EQ(after([](proto::Hello&) {}), "agreed");
    EXPECT_EQ(after([](proto::Hello& hello) { hello.set_nonce(8); }), "agreed");
}

TEST(Handshake, SaysWhatDiffers) {
    EXPECT_EQ(after([](proto::Hello& hello) { hello.set_version(77); }), "wire version 77 is not ours, 3");
    EXPECT_EQ(after([](proto::Hello& hello) { hello.set_lockstep(true); }),
              "they run in lockstep, we do not");
    EXPECT_NE(after([](proto::Hello& hello) { hello.set_safe_ms(200); }).find("safe_ms: 150 -> 200"),
              std::string::npos);
    EXPECT_NE(after([](proto::Hello& hello) {
                  hello.mutable_patch(0)->mutable_neuron()->set_tau_m_ms(11);
              }).find("patch[0].neuron.tau_m_ms: 10 -> 11"),
              std::string::npos);
}

// The refusal names the parts that differ, and shows no fingerprint: it would let a peer pretend to have the
// same scene.
TEST(Handshake, NamesThePartsOfTheSceneThatDiffer) {
    const auto with_parts = [](std::uint64_t scene,
                               std::initializer_list<std::pair<const char*, int>> parts) {
        proto::Hello hello = hello_with_a_patch();
        hello.set_scene_fingerprint(scene);
        for (const auto& [name, fingerprint] : parts) {
            auto* const part = hello.add_part();
            part->set_name(name);
            part->set_fingerprint(static_cast<std::uint32_t>(fingerprint));
        }
        return hello;
    };
    const proto::Hello ours =
        with_parts(0x1234, {{"decoder.window_ms", 1}, {"link.packet_ms", 2}, {"seed", 3}});
    proto::Hello theirs =
        with_parts(0x5678, {{"decoder.window_ms", 1}, {"gain.limit_n", 9}, {"link.packet_ms", 4}});
    EXPECT_EQ(disagreement(theirs, ours), "the scenes differ in gain.limit_n, link.packet_ms, seed");
    theirs.set_packet_ms(10);
    EXPECT_EQ(disagreement(theirs, ours),
              "the scenes differ in gain.limit_n, link.packet_ms, seed; from ours to theirs: modified: "
              "packet_ms: 5 -> 10");
    EXPECT_EQ(disagreement(with_parts(0x5678, {}), with_parts(0x1234, {})), "the scenes differ");
    proto::Hello made_up = with_parts(0x5678, {});
    for (int i = 0; i < 1000; ++i) made_up.add_part()->set_name(std::string(1000, 'x') + std::to_string(i));
    const auto text = disagreement(made_up, ours);
    ASSERT_TRUE(text);
    EXPECT_LT(text->size(), 400U);
    EXPECT_NE(text->find("and 997 more"), std::string::npos) << *text;
    EXPECT_NE(text->find(std::string(40, 'x')), std::string::npos) << *text;
    EXPECT_EQ(text->find(std::string(41, 'x')), std::string::npos) << *text;
}

TEST(Handshake, GivesTheLayoutThatWasDescribed) {
    const PacketLayout layout{.addresses = 1000,
                              .tick = 1us,
                              .span = 1ms,
                              .heartbeat = 7ms,
                              .encoding = Encoding::fixed_width,
                              .max_events = 77};
    proto::Hello hello = hello_with_a_patch();
    describe(layout, hello);
    ASSERT_TRUE(layout_of(hello));
    EXPECT_EQ(layout_of(hello).value(), layout);
}

TEST(Handshake, TellsOfPromptPackets) {
    const PacketLayout layout{.addresses = 9, .span = 1ms, .gathered_spans = 5};
    proto::Hello hello = hello_with_a_patch();
    EXPECT_EQ(hello.prompt_ms(), 0) << "every packet closes after packet_ms";
    describe(layout, hello);
    EXPECT_EQ(hello.packet_ms(), 5);
    EXPECT_EQ(hello.prompt_ms(), 1);
    ASSERT_TRUE(layout_of(hello));
    EXPECT_EQ(layout_of(hello).value(), layout);
}

TEST(Handshake, RefusesLayoutsThatCannotBe) {
    const auto refusal = [](auto change) {
        proto::Hello hello = hello_with_a_patch();
        change(hello);
        const auto layout = layout_of(hello);
        return layout ? std::string("accepted") : layout.error().text;
    };
    EXPECT_EQ(refusal([](auto&) {}), "accepted");
    for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
        EXPECT_NE(refusal([&](auto& hello) { hello.set_tick_us(bad); }), "accepted");
        EXPECT_NE(refusal([&](auto& hello) { hello.set_packet_ms(bad); }), "accepted");
        EXPECT_NE(refusal([&](auto& hello) { hello.set_heartbeat_ms(bad); }), "accepted");
    }
    EXPECT_NE(refusal([](auto& hello) { hello.set_tick_us(0); }).find("tick_us must be > 0"),
              std::string::npos);
    EXPECT_NE(refusal([](auto& hello) { hello.set_addresses(0); }).find("addresses must be > 0"),
              std::string::npos);
    for (const double bad : {-1.0, 3.0, 10.0, 1e-6, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_NE(refusal([&](auto& hello) { hello.set_prompt_ms(bad); }), "accepted") << bad;
    EXPECT_EQ(refusal([](auto& hello) { hello.set_prompt_ms(2.5); }), "accepted");
    EXPECT_NE(refusal([](auto& hello) { hello.set_freeze_ms(49); }).find("at least twice"),
              std::string::npos);
    EXPECT_NE(refusal([](auto& hello) { hello.set_safe_ms(60); }).find("safe_ms must be > freeze_ms"),
              std::string::npos);
    EXPECT_NE(refusal([](auto& hello) { hello.set_encoding(static_cast<proto::PayloadEncoding>(5)); }),
              "accepted");
}

}  // namespace
}  // namespace afferent
