// The Ability Hand's protocol: bytes by hand, the law of its sensors, and a line that is disturbed.
#include "afferent/hand/ability_hand.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <random>

#include "tests/long_runs.hpp"

namespace afferent {
namespace {

using ability_hand::FrameReader;
using ability_hand::Mode;
using ability_hand::Reply;
using ability_hand::Request;
using ability_hand::Variant;
using Bytes = std::vector<std::byte>;

Bytes bytes(std::initializer_list<unsigned> values) {
    Bytes all;
    for (const unsigned value : values) all.push_back(static_cast<std::byte>(value));
    return all;
}

std::vector<Bytes> payloads(FrameReader& reader, const Bytes& line) {
    std::vector<Bytes> all;
    reader.read(
        line, [&](std::span<const std::byte> payload) { all.emplace_back(payload.begin(), payload.end()); });
    return all;
}

TEST(AbilityHand, WritesRequestsAsItsMakerDocumentsThem) {
    Bytes line;
    ability_hand::append_request(
        0x50, {.command = {.mode = Mode::position, .values = {150, -75, 0, 0, 0, 0}}}, line);
    // 32767 = 0x7fff; -16384 = 0xc000, rounded away from -16383.5; the checksum makes the sum 0.
    EXPECT_EQ(line, bytes({0x7e, 0x50, 0x10, 0xff, 0x7f, 0x00, 0xc0, 0, 0, 0, 0, 0, 0, 0, 0, 0x62, 0x7e}));
}

TEST(AbilityHand, EscapesFlagsAndEscapes) {
    Bytes line;
    ability_hand::append_request(0x7e, {}, line);
    EXPECT_EQ(line, bytes({0x7e, 0x7d, 0x5e, 0xa0, 0xe2, 0x7e}));
    FrameReader reader;
    EXPECT_EQ(payloads(reader, line), std::vector<Bytes>{bytes({0x7e, 0xa0})});
}

TEST(AbilityHand, PacksTwoReadingsIntoThreeBytes) {
    Reply reply;
    reply.counts[0] = 0xabc;
    reply.counts[1] = 0x123;
    reply.counts[29] = 0xfff;
    Bytes line;
    ability_hand::append_reply(reply, line);
    FrameReader reader;
    const auto found = payloads(reader, line);
    ASSERT_EQ(found.size(), 1U);
    ASSERT_EQ(found[0].size(), 71U);
    EXPECT_EQ(Bytes(found[0].begin() + 25, found[0].begin() + 28), bytes({0xbc, 0x3a, 0x12}));
    EXPECT_EQ(Bytes(found[0].begin() + 67, found[0].begin() + 70), bytes({0x00, 0xf0, 0xff}));
}

TEST(AbilityHand, ReadsWhatItWrites) {
    for (const Variant variant :
         {Variant::current_and_sensors, Variant::velocity_and_sensors, Variant::current_and_velocity}) {
        Reply reply{.mode = Mode::duty, .variant = variant, .status = 3};
        for (std::size_t i = 0; i < ability_hand::motors; ++i) {
            reply.position_deg[i] = 10.0 * static_cast<double>(i) - 20;
            reply.current_a[i] = 0.25 * static_cast<double>(i);
            reply.velocity_deg_per_s[i] = 30.0 * static_cast<double>(i);
        }
        for (std::size_t i = 0; i < ability_hand::sensors; ++i)
            reply.counts[i] = static_cast<std::uint16_t>(137 * i);
        Bytes line;
        ability_hand::append_reply(reply, line);
        FrameReader reader;
        const auto found = payloads(reader, line);
        ASSERT_EQ(found.size(), 1U);
        const auto read = ability_hand::read_reply(found[0]);
        ASSERT_TRUE(read);
        EXPECT_EQ(read->mode, Mode::duty);
        EXPECT_EQ(read->variant, variant);
        EXPECT_EQ(read->status, 3U);
        const bool has_sensors = variant != Variant::current_and_velocity;
        const bool has_current = variant != Variant::velocity_and_sensors;
        const bool has_velocity = variant != Variant::current_and_sensors;
        for (std::size_t i = 0; i < ability_hand::motors; ++i) {
            // Half a step of the wire.
            EXPECT_NEAR(read->position_deg[i], reply.position_deg[i], 150.0 / 32767 / 2 + 1e-12);
            EXPECT_NEAR(read->current_a[i], has_current ? reply.current_a[i] : 0, 0.5 / 620 + 1e-12);
            EXPECT_NEAR(read->velocity_deg_per_s[i], has_velocity ? reply.velocity_deg_per_s[i] : 0,
                        750.0 / 32767);
        }
        for (std::size_t i = 0; i < ability_hand::sensors; ++i)
            EXPECT_EQ(read->counts[i], has_sensors ? reply.counts[i] : 0);
    }
}

TEST(AbilityHand, RefusesOtherLengthsAddressesAndModes) {
    EXPECT_FALSE(ability_hand::read_reply({}));
    EXPECT_FALSE(ability_hand::read_reply(Bytes(70, std::byte{0x10})));
    EXPECT_FALSE(ability_hand::read_reply(Bytes(71, std::byte{0x13})));
    EXPECT_FALSE(ability_hand::read_reply(Bytes(71, std::byte{0x50})));
    EXPECT_FALSE(ability_hand::read_reply(Bytes(38, std::byte{0x10})));
    EXPECT_TRUE(ability_hand::read_reply(Bytes(71, std::byte{0x10})));
    EXPECT_FALSE(ability_hand::read_request(0x50, bytes({0x51, 0xa0})));
    EXPECT_FALSE(ability_hand::read_request(0x50, bytes({0x50})));
    EXPECT_FALSE(ability_hand::read_request(0x50, bytes({0x50, 0x10})));
    EXPECT_TRUE(ability_hand::read_request(0x50, bytes({0x50, 0xa0})));
}

TEST(AbilityHand, ClipsWhatTheWireCannotCarry) {
    Bytes line;
    ability_hand::append_request(
        0x50, {.command = {.mode = Mode::current, .values = {1e9, -1e9, std::nan(""), 0, 0, 0}}}, line);
    FrameReader reader;
    const auto read = ability_hand::read_request(0x50, payloads(reader, line).at(0));
    ASSERT_TRUE(read);
    EXPECT_NEAR(read->command.values[0], 32767 / 620.606079, 1e-9);
    EXPECT_NEAR(read->command.values[1], -32767 / 620.606079, 1e-9);
    EXPECT_EQ(read->command.values[2], 0);
}

TEST(AbilityHand, HasTheForceOfItsMakersLaw) {
    // At half of 3.3 V: 121591 / (33000 / 1.65 + 10000) + 0.878894.
    EXPECT_NEAR(ability_hand::force_n(2048), 121591.0 / 30000 + 0.878894, 1e-12);
    EXPECT_NEAR(ability_hand::force_n(0), 0.878894, 1e-12);
    for (double counts = 0; counts < 4095; ++counts) {
        EXPECT_LT(ability_hand::force_n(counts), ability_hand::force_n(counts + 1));
        EXPECT_NEAR(ability_hand::counts_at(ability_hand::force_n(counts)), counts, 1e-8);
    }
    EXPECT_EQ(ability_hand::counts_at(0.5), 0);
    EXPECT_EQ(ability_hand::counts_at(100), 4095);
}

// The second of three frames suffers one fault: the reader finds the frames that are still whole, and no
// others.
TEST(AbilityHand, FindsEveryWholeFrameBehindAFaultAndNoFalseOne) {
    std::mt19937_64 random(1);
    const auto below = [&random](std::size_t end) { return static_cast<std::size_t>(random() % end); };
    const int faults = long_runs ? 200'000 : 10'000;
    FrameReader reader;
    int damaged_wholly = 0;
    for (int i = 0; i < faults; ++i) {
        std::array<Reply, 3> replies;
        std::array<Bytes, 3> frames;
        for (std::size_t k = 0; k < 3; ++k) {
            // Bytes that have to be escaped are frequent.
            for (auto& counts : replies[k].counts)
                counts = static_cast<std::uint16_t>(below(4) == 0 ? 0x7d7 + below(2) * 0x10 : below(4096));
            ability_hand::append_reply(replies[k], frames[k]);
        }
        Bytes& hurt = frames[1];
        const Bytes whole = hurt;
        const auto place = static_cast<std::ptrdiff_t>(below(hurt.size()));
        switch (below(4)) {
            case 0:
                hurt.erase(hurt.begin(), hurt.begin() + 1 + place);
                break;
            case 1:
                hurt.insert(hurt.begin() + place, 1 + below(3), std::byte{0});
                break;
            case 2:
                hurt[static_cast<std::size_t>(place)] ^= static_cast<std::byte>(1U << below(8));
                break;
            default:
                hurt.resize(static_cast<std::size_t>(place));
        }
        Bytes line;
        for (const Bytes& frame : frames) line.insert(line.end(), frame.begin(), frame.end());
        std::vector<Reply> found;
        for (const Bytes& payload : payloads(reader, line))
            if (const auto reply = ability_hand::read_reply(payload)) found.push_back(*reply);
        std::vector<std::size_t> expected{0, 2};
        // Zeros before the frame, or a flag that its neighbour's flag stands for, leave it whole.
        if (found.size() == 3) expected = {0, 1, 2};
        ASSERT_EQ(found.size(), expected.size()) << "fault " << i;
        if (found.size() == 2) ++damaged_wholly;
        for (std::size_t k = 0; k < found.size(); ++k)
            ASSERT_EQ(found[k].counts, replies[expected[k]].counts) << "fault " << i;
    }
    EXPECT_GT(damaged_wholly, faults / 2);
}

TEST(AbilityHand, IsBackInStepAfterAnythingAtAll) {
    std::mt19937_64 random(2);
    FrameReader reader;
    for (int i = 0; i < 1000; ++i) {
        Bytes line(random() % 1000);
        for (std::byte& byte : line) byte = static_cast<std::byte>(random());
        reader.read(line, [](auto payload) { EXPECT_LT(payload.size(), 96U); });
        Bytes frame;
        ability_hand::append_reply({}, frame);
        EXPECT_EQ(payloads(reader, frame).size(), 1U);
    }
    EXPECT_GT(reader.refused(), 1000U);
}

}  // namespace
}  // namespace afferent
