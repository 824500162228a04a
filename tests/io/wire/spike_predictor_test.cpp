#include "afferent/io/wire/spike_predictor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/io/wire/wandering_trains.hpp"

namespace afferent {
namespace {

// The two ends of a link without one.
struct BothEnds {
    explicit BothEnds(const PacketLayout& layout) : coprocessor(layout), hand(layout) {}

    std::vector<Code> pass(std::span<const Code> codes, SpikePredictor::Manner manner = {}) {
        sent = coprocessor.encode(codes, payload, manner);
        EXPECT_NE(sent, payload.empty());
        const auto told = hand.decode(std::as_bytes(std::span(payload)), manner.exactly);
        EXPECT_TRUE(told) << told.error().text;
        if (!told) return {};
        EXPECT_EQ(coprocessor.told().size(), told.value().size());
        EXPECT_EQ(coprocessor.check(), hand.check());
        return {told.value().begin(), told.value().end()};
    }

    SpikePredictor coprocessor;
    SpikePredictor hand;
    std::string payload;
    bool sent = false;
};

TEST(SpikePredictor, TellsEveryEventToItsTick) {
    for (const auto& [addresses, tick, span] : {std::tuple<Address, Duration, Duration>{1, 100us, 5ms},
                                                {9, 100us, 5ms},
                                                {300, 100us, 5ms},
                                                {40, 100us, 50ms},
                                                {9, 100us, 100us},
                                                {70, 1us, 1ms}}) {
        PacketLayout layout = predicted(addresses);
        layout.tick = tick;
        layout.span = span;
        layout.heartbeat = std::max<Duration>(span, 25ms);
        BothEnds ends(layout);
        for (const std::vector<Code>& codes : wandering(layout, 3'000, addresses))
            ASSERT_EQ(ends.pass(codes), codes);
    }
}

TEST(SpikePredictor, TellsWhatNoNeuronWouldDo) {
    PacketLayout layout = predicted(5);
    layout.max_events = 400;
    BothEnds ends(layout);
    std::mt19937_64 random(2);
    for (int span = 0; span < 2'000; ++span) {
        // From nothing to storms, with several events of one afferent in one tick.
        std::vector<Code> codes(random() % (span % 7 == 0 ? 401 : 4));
        for (Code& code : codes) code = static_cast<Code>(random() % layout.codes());
        std::sort(codes.begin(), codes.end());
        ASSERT_EQ(ends.pass(codes), codes);
    }
}

// Two patches of ten, whose intervals rise and fall with these periods, in seconds.
Spans pulsing(const PacketLayout& layout, std::array<double, 2> periods) {
    Spans spans(4'000);
    const auto ticks = static_cast<double>(layout.span / layout.tick);
    for (Address address = 0; address < 20; ++address) {
        const double own = 1 + 0.04 * (address % 10);
        for (double tick = 7.0 * address; tick < ticks * static_cast<double>(spans.size());) {
            const double turn = tick * 1e-4 / periods[address / 10];
            spans[static_cast<std::size_t>(tick / ticks)].push_back(
                static_cast<Code>(std::fmod(tick, ticks)) * 20 + address);
            tick += own * (150 + 60 * std::sin(2 * std::numbers::pi * turn));
        }
    }
    for (auto& codes : spans) std::sort(codes.begin(), codes.end());
    return spans;
}

double information_bits(const PacketLayout& layout, const Spans& spans) {
    BothEnds ends(layout);
    double bits = 0;
    for (const std::vector<Code>& codes : spans) {
        EXPECT_EQ(ends.pass(codes), codes);
        bits += ends.coprocessor.information_bits();
    }
    return bits;
}

TEST(SpikePredictor, LetsPatchesCountForEachOtherAsFarAsTheyChangeAlike) {
    const PacketLayout one = predicted(20);
    PacketLayout two = one;
    two.neurons = {{10, {}}, {10, {}}};
    const Spans alike = pulsing(one, {1.1, 1.1});
    EXPECT_NEAR(information_bits(two, alike) / information_bits(one, alike), 1, 0.03);
    const Spans apart = pulsing(one, {1.1, 0.7});
    EXPECT_LT(information_bits(two, apart), 0.93 * information_bits(one, apart));
}

TEST(SpikePredictor, IsTheSameOnEveryMachine) { EXPECT_EQ(payload_checksum(), expected_checksum); }

TEST(SpikePredictor, SaysNothingOfASpikeThatComesAsForeseen) {
    const PacketLayout layout = predicted(1, 500us);
    BothEnds ends(layout);
    const auto ticks = static_cast<std::uint32_t>(layout.span / layout.tick);
    // A neuron under a drive that is held, as its own table has it.
    const IntervalLaw law({}, layout.tick);
    const std::uint32_t drive = law.drive(16 * 170, 4 * law.first_adaptation());
    std::uint32_t g = law.first_adaptation();
    std::uint64_t now = 0;
    std::vector<std::uint64_t> spikes;
    for (int spike = 0; spike < 500; ++spike) {
        spikes.push_back(now);
        const std::uint32_t interval = law.interval(drive, g);
        g = law.next_adaptation(g, interval / 16);
        now += interval / 16;
    }
    std::size_t sent = 0;
    std::size_t told = 0;
    auto next = spikes.begin();
    for (std::uint32_t span = 0; span * ticks < now; ++span) {
        std::vector<Code> codes;
        for (; next != spikes.end() && *next < (span + 1) * ticks; ++next)
            codes.push_back(static_cast<Code>(*next - span * ticks));
        told += ends.pass(codes).size();
        sent += ends.sent ? 1 : 0;
    }
    EXPECT_NEAR(static_cast<double>(told), 500, 1);
    EXPECT_LT(sent, 25U) << "the first few, and then none";
}

TEST(SpikePredictor, KeepsToItsTolerance) {
    for (const Duration tolerance : {Duration(100us), Duration(500us), Duration(2400us)}) {
        const PacketLayout layout = predicted(30, tolerance);
        const auto ticks = static_cast<std::uint32_t>(layout.span / layout.tick);
        BothEnds ends(layout);
        std::vector<std::vector<std::int64_t>> fired(layout.addresses);
        std::vector<std::vector<std::int64_t>> told(layout.addresses);
        const Spans spans = wandering(layout, 2'000, 4);
        for (std::size_t span = 0; span < spans.size(); ++span) {
            const auto begin = static_cast<std::int64_t>(span * ticks);
            for (const Code code : spans[span])
                fired[code % layout.addresses].push_back(begin + code / layout.addresses);
            for (const Code code :
                 ends.pass(spans[span], {.exactly = false, .last = span + 1 == spans.size()}))
                told[code % layout.addresses].push_back(begin + code / layout.addresses);
        }
        EXPECT_EQ(ends.coprocessor.waiting(), 0U);
        std::int64_t furthest = 0;
        for (Address address = 0; address < layout.addresses; ++address) {
            std::sort(told[address].begin(), told[address].end());
            ASSERT_EQ(told[address].size(), fired[address].size());
            for (std::size_t i = 0; i < fired[address].size(); ++i)
                furthest = std::max(furthest, std::abs(told[address][i] - fired[address][i]));
        }
        EXPECT_EQ(furthest * layout.tick, tolerance) << "it is used, and not exceeded";
    }
}

// The bytes of all spans, predicted, as a part of those of Rice codes.
double part_of_rice(const PacketLayout& layout, const Spans& spans) {
    PacketLayout independent = layout;
    independent.encoding = Encoding::rice;
    SpikePredictor predictor(layout);
    PayloadCodec rice(independent);
    std::string payload;
    std::size_t bytes = 0;
    std::size_t rice_bytes = 0;
    for (const std::vector<Code>& codes : spans) {
        predictor.encode(codes, payload, {});
        bytes += payload.size();
        rice.encode(codes, payload);
        rice_bytes += payload.size();
    }
    return static_cast<double>(bytes) / static_cast<double>(rice_bytes);
}

TEST(SpikePredictor, TakesFewerBytesThanRice) {
    const PacketLayout layout = predicted(200);
    EXPECT_LT(part_of_rice(layout, wandering(layout, 1'000, 5)), 0.65);
}

TEST(SpikePredictor, TakesWhatSomeHaveShownForAllOfTheirLaw) {
    // Drives that rise and fall together, or each by itself: with the same intervals, in another order.
    const auto bytes = [](bool together, std::size_t laws) {
        PacketLayout layout = predicted(300);
        layout.neurons.clear();
        for (std::size_t law = 0; law < laws; ++law)
            layout.neurons.push_back(
                {static_cast<Address>(300 / laws), {.tau_m_ms = 10 + 0.01 * static_cast<double>(law)}});
        Spans spans(600);
        std::mt19937_64 random(10);
        for (Address address = 0; address < 300; ++address) {
            const double base = 100 + static_cast<double>(random() % 150);
            const double phase = together ? 0 : static_cast<double>(random() % 628) / 100;
            for (double tick = static_cast<double>(random() % 100); tick < 50.0 * 600;) {
                const auto at = static_cast<std::size_t>(tick);
                spans[at / 50].push_back(static_cast<Code>(at % 50 * 300 + address));
                tick += base * (1 + 0.3 * std::sin(tick / 3000 + phase));
            }
        }
        SpikePredictor predictor(layout);
        std::string payload;
        std::size_t sum = 0;
        for (auto& codes : spans) {
            std::sort(codes.begin(), codes.end());
            predictor.encode(codes, payload, {});
            sum += payload.size();
        }
        return static_cast<double>(sum);
    };
    EXPECT_LT(bytes(true, 1), 0.8 * bytes(false, 1));
    EXPECT_LT(bytes(true, 1), 0.9 * bytes(true, 300)) << "with each its own law, none knows of the others";
}

// One afferent after another begins, and fires three times, every 120 ticks or so: what the first has shown
// is expected of the second interval of all.
TEST(SpikePredictor, ExpectsTheFirstIntervalOfAnAfferentToBeThatOfOthers) {
    const PacketLayout layout = predicted(300);
    Spans spans(700);
    std::mt19937_64 random(11);
    for (Address address = 0; address < 300; ++address) {
        std::size_t tick = std::size_t{100} * address + random() % 100;
        for (int spike = 0; spike < 3; ++spike, tick += 118 + random() % 5)
            spans[tick / 50].push_back(static_cast<Code>(tick % 50 * 300 + address));
    }
    for (auto& codes : spans) std::sort(codes.begin(), codes.end());
    EXPECT_LT(part_of_rice(layout, spans), 0.8);
}

TEST(SpikePredictor, StartsOver) {
    const PacketLayout layout = predicted(9);
    const Spans spans = wandering(layout, 200, 6);
    SpikePredictor used(layout);
    SpikePredictor fresh(layout);
    std::string payload;
    std::string expected;
    for (const std::vector<Code>& codes : spans) used.encode(codes, payload, {});
    // Whatever came last: further parts of a span, of which the other end may know nothing.
    used.add(spans[5]);
    used.restart(1'000'000'050);
    fresh.restart(1'000'000'050);
    EXPECT_EQ(used.check(), fresh.check());
    for (const std::vector<Code>& codes : spans) {
        used.encode(codes, payload, {});
        fresh.encode(codes, expected, {});
        ASSERT_EQ(payload, expected);
    }
}

TEST(SpikePredictor, GoesOnForLongerThanItsClock) {
    // 2^28 ticks are 268 s of a microsecond each.
    PacketLayout layout = predicted(2);
    layout.tick = 1us;
    BothEnds ends(layout);
    ends.coprocessor.restart((1U << 28) - 20'000);
    ends.hand.restart((1U << 28) - 20'000);
    for (const std::vector<Code>& codes : wandering(layout, 100, 7)) ASSERT_EQ(ends.pass(codes), codes);
}

TEST(SpikePredictor, RefusesWhatNoSenderWrites) {
    std::mt19937_64 random(8);
    PacketLayout layout = predicted(50);
    layout.max_events = 20;
    const SpikePredictor untouched(layout);
    int refused = 0;
    for (int repetition = 0; repetition < 5'000; ++repetition) {
        SpikePredictor hand(untouched);
        for (int span = 0; span < 3; ++span) {
            std::string payload(1 + random() % 60, '\0');
            for (char& byte : payload) byte = static_cast<char>(random() % 4 == 0 ? 0xff : random());
            const auto codes = hand.decode(std::as_bytes(std::span(payload)), random() % 2 == 0);
            refused += codes ? 0 : 1;
            if (!codes) continue;
            EXPECT_LE(codes.value().size(), layout.max_events);
            for (const Code code : codes.value()) EXPECT_LT(code, layout.codes());
        }
    }
    EXPECT_GT(refused, 10'000);
}

TEST(SpikePredictor, WritesNoLongerPayloadThanItSays) {
    PacketLayout layout = predicted(40);
    layout.max_events = 100;
    SpikePredictor predictor(layout);
    std::string payload;
    std::size_t longest = 0;
    std::mt19937_64 random(9);
    for (int span = 0; span < 3'000; ++span) {
        // Volleys of all, and then none where they are foreseen.
        std::vector<Code> codes;
        for (Code code = 0; span % 3 == 0 && code < 100; ++code)
            codes.push_back(static_cast<Code>(random() % layout.codes()));
        std::sort(codes.begin(), codes.end());
        predictor.encode(codes, payload, {});
        longest = std::max(longest, payload.size());
    }
    EXPECT_LE(longest, SpikePredictor::most_bytes(layout));
    EXPECT_GT(longest, 60U);
}

}  // namespace
}  // namespace afferent
