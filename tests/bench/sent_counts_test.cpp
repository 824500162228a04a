// The rivals of events: what they send, and what the other end makes of it.
#include "bench/sent_counts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "bench/change_coder.hpp"
#include "bench/link_schemes.hpp"

namespace afferent {
namespace {

// What one element sends, scan by scan, of these counts.
std::vector<CountChange> sent_of(const ChangeRule& rule, const std::vector<std::uint16_t>& counts) {
    SentCounts sender(1, rule);
    std::vector<CountChange> changes;
    for (std::size_t i = 0; i < counts.size(); ++i)
        sender.send(std::span(counts).subspan(i, 1), static_cast<std::uint32_t>(i), changes);
    return changes;
}

// Up, held and down again, with noise of a count, in each element by another amount.
std::vector<std::vector<std::uint16_t>> noisy_scans(std::uint32_t elements) {
    std::mt19937_64 random(3);
    std::vector<std::vector<std::uint16_t>> scans;
    for (int k = 0; k < 400; ++k) {
        const int level = k < 100   ? 0
                          : k < 150 ? 20 * (k - 100)
                          : k < 300 ? 1000
                                    : std::max(0, 10 * (400 - k));
        auto& scan = scans.emplace_back();
        for (std::uint32_t e = 0; e < elements; ++e)
            scan.push_back(static_cast<std::uint16_t>(level * (e + 1) / elements + random() % 2));
    }
    return scans;
}

TEST(SentCounts, SendsWholeDeltas) {
    const auto sent = sent_of({.band = 10}, {9, 10, 19, 35, 21, 20});
    // To 10, on to 30 at 35, and back to 20 at 20.
    EXPECT_EQ(sent, (std::vector<CountChange>{{1, 1}, {3, 2}, {5, -1}}));
}

TEST(SentCounts, SendsNothingOfALineAfterItsStart) {
    std::vector<std::uint16_t> ramp(10, 0);
    for (int k = 1; k <= 200; ++k) ramp.push_back(static_cast<std::uint16_t>(16 * k));
    const auto line = sent_of({.band = 32, .linear = true}, ramp);
    // At the first band, of 32 counts, the line through the last four scans (0, 0, 16, 32) rises by 11.2
    // counts a scan, sent as 11/32 of a band; that is 5 too few, so that a band is missing after 7 scans.
    // Then all four are of the ramp.
    EXPECT_EQ(line, (std::vector<CountChange>{{11, 1, 11}, {18, 1, 16}}));
    // Without the line it is sent at every second scan.
    EXPECT_EQ(sent_of({.band = 32}, ramp).size(), 100U);
}

TEST(SentCounts, HasADeadBandThatGrowsWithTheValue) {
    const ChangeRule rule{.band = 4, .fraction = 0.1};
    // Near 0 the least band of 4, at 1,000 a band of 100, which is sent whole.
    EXPECT_EQ(sent_of(rule, {3, 4}), (std::vector<CountChange>{{1, 1}}));
    SentCounts sender(1, rule);
    std::vector<CountChange> changes;
    const std::array<std::uint16_t, 1> high{1000};
    sender.send(high, 0, changes);
    ASSERT_EQ(sender.presumed(0), 1000);
    changes.clear();
    for (const std::uint16_t count : {std::uint16_t{1099}, std::uint16_t{901}}) {
        sender.send(std::array{count}, 0, changes);
        EXPECT_TRUE(changes.empty()) << count;
    }
    sender.send(std::array<std::uint16_t, 1>{1100}, 0, changes);
    EXPECT_EQ(changes, (std::vector<CountChange>{{0, 1}}));

    LinkActivity activity{.name = "", .elements = 1};
    activity.noise_counts = 1.5;
    EXPECT_EQ(dead_band_rule(activity, 0.1, 1).band, 6) << "four standard deviations";
    EXPECT_EQ(dead_band_rule(activity, 0.1, 41).band, 41);
}

// The receiver presumes what the sender does, from the bytes alone, and each count is within what it takes
// for its range.
TEST(ChangeCoder, TellsTheOtherEndWhatTheSenderPresumes) {
    constexpr std::uint32_t elements = 7;
    constexpr std::uint32_t batch = 4;
    const auto scans = noisy_scans(elements);
    for (const ChangeRule& rule :
         {ChangeRule{}, ChangeRule{.band = 12}, ChangeRule{.band = 12, .linear = true},
          ChangeRule{.band = 4, .fraction = 0.1}}) {
        SentCounts sender(elements, rule);
        SentCounts receiver(elements, rule);
        ChangeCoder writer(elements, rule.linear);
        ChangeCoder reader(elements, rule.linear);
        std::vector<CountChange> changes;
        std::vector<CountChange> received;
        std::string payload;
        std::size_t bytes = 0;
        for (std::size_t first = 0; first < scans.size(); first += batch) {
            changes.clear();
            for (std::uint32_t i = 0; i < batch; ++i) {
                sender.send(scans[first + i], i * elements, changes);
                for (std::uint32_t e = 0; e < elements; ++e) {
                    EXPECT_LE(sender.range(e).low, scans[first + i][e]);
                    EXPECT_GE(sender.range(e).high, scans[first + i][e]);
                }
            }
            writer.encode(changes, batch, payload);
            EXPECT_EQ(payload.empty(), changes.empty());
            bytes += payload.size();
            ASSERT_TRUE(reader.decode(payload, batch, received));
            ASSERT_EQ(received, changes);
            for (std::uint32_t i = 0; i < batch; ++i) {
                const auto until = [&](std::uint32_t scan) {
                    return std::ranges::lower_bound(received, scan * elements, {}, &CountChange::element);
                };
                receiver.receive({until(i), until(i + 1)}, i * elements);
            }
            for (std::uint32_t e = 0; e < elements; ++e) EXPECT_EQ(receiver.presumed(e), sender.presumed(e));
        }
        EXPECT_GT(bytes, 0U);
        // Differences of noise of half a count take 1.5 bits, and those of ramps more; varints take 8.
        EXPECT_LT(bytes, scans.size() * elements * (rule.band > 1 ? 1 : 3) / 8);
    }
}

}  // namespace
}  // namespace afferent
