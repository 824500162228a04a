#include "afferent/io/links/channel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/relay.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/counts_nothing.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

constexpr TimePoint forever = TimePoint::max();

std::vector<std::byte> frame(int number, std::size_t size = 20) {
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::byte>(number >> (8 * i));
    return bytes;
}

int number(std::span<const std::byte> bytes) {
    int value = 0;
    for (int i = 0; i < 4; ++i) value |= std::to_integer<int>(bytes[static_cast<std::size_t>(i)]) << (8 * i);
    return value;
}

struct Arrival {
    TimePoint time;
    int number;
    friend bool operator==(const Arrival&, const Arrival&) = default;
};

std::vector<Arrival> arrivals(Channel& channel, TimePoint until = forever) {
    std::vector<Arrival> found;
    while (const auto time = channel.next_arrival(until)) found.push_back({*time, number(channel.arrive())});
    return found;
}

// Frames of 20 bytes, one each 5 ms.
std::vector<Arrival> run(const ChannelParameters& parameters, int frames, ChannelCounts* counts = nullptr) {
    Channel channel(parameters);
    for (int i = 0; i < frames; ++i) channel.send(at(i * 5ms), frame(i), 1);
    auto found = arrivals(channel);
    EXPECT_TRUE(channel.empty());
    if (counts != nullptr) *counts = channel.counts();
    return found;
}

// Within six standard deviations of a binomial.
void expect_share(std::uint64_t count, double probability, int of) {
    EXPECT_NEAR(static_cast<double>(count), probability * of,
                6 * std::sqrt(probability * (1 - probability) * of));
}

TEST(Channel, CountsFromNothing) {
    EXPECT_TRUE(counts_nothing<ChannelCounts>());
    EXPECT_TRUE(counts_nothing<LinkCounts>());
    EXPECT_TRUE(counts_nothing<RelayCounts>());
    EXPECT_TRUE(counts_nothing<CarriedBytes>());
}

TEST(Channel, ThatDoesNothingDeliversAtOnce) {
    const auto found = run({}, 100);
    ASSERT_EQ(found.size(), 100U);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(found[static_cast<std::size_t>(i)], (Arrival{at(i * 5ms), i}));
}

TEST(Channel, DelaysByLatencyAndTheTimeOnTheLine) {
    Channel channel({.bandwidth_bps = 16'000, .latency = 3ms});
    // 20 bytes take 10 ms: the second waits for the first.
    channel.send(at(0ms), frame(0), 1);
    channel.send(at(5ms), frame(1), 1);
    EXPECT_FALSE(channel.next_arrival(at(13ms - 1ns)));
    EXPECT_EQ(arrivals(channel), (std::vector<Arrival>{{at(13ms), 0}, {at(23ms), 1}}));
}

TEST(Channel, JittersWithinItsBoundsAndKeepsTheOrder) {
    ChannelParameters parameters{.latency = 1ms, .jitter = 20ms};
    const auto found = run(parameters, 1000);
    ASSERT_EQ(found.size(), 1000U);
    std::set<Duration> delays;
    for (int i = 0; i < 1000; ++i) {
        const Arrival& arrival = found[static_cast<std::size_t>(i)];
        EXPECT_EQ(arrival.number, i);
        const Duration delay = arrival.time - at(i * 5ms);
        EXPECT_GE(delay, 1ms);
        EXPECT_LE(delay, 21ms);
        delays.insert(delay);
    }
    EXPECT_GT(delays.size(), 900U);
}

TEST(Channel, LosesRepeatsReordersAndChangesTheSharesItWasTold) {
    constexpr int frames = 20'000;
    ChannelCounts counts;
    run({.latency = 7ms, .loss = 0.1}, frames, &counts);
    expect_share(counts.lost, 0.1, frames);
    run({.latency = 7ms, .duplicate = 0.2}, frames, &counts);
    expect_share(counts.duplicated, 0.2, frames);
    EXPECT_EQ(counts.arrived, frames + counts.duplicated);
    const auto found = run({.latency = 7ms, .reorder = 0.3}, frames, &counts);
    expect_share(counts.reordered, 0.3, frames);
    int overtaken = 0;
    for (std::size_t i = 1; i < found.size(); ++i) overtaken += found[i].number < found[i - 1].number ? 1 : 0;
    // Delayed by 7 ms more, a frame is overtaken by the next, 5 ms behind, unless that is delayed as well.
    expect_share(static_cast<std::uint64_t>(overtaken), 0.3 * 0.7, frames);

    Channel channel({.corrupt = 0.4});
    int changed = 0;
    for (int i = 0; i < frames; ++i) {
        channel.send(at(i * 1ms), frame(i), 1);
        while (channel.next_arrival(at(i * 1ms))) {
            const auto bytes = channel.arrive();
            int bits = 0;
            for (std::size_t b = 0; b < bytes.size(); ++b)
                bits += std::popcount(std::to_integer<unsigned>(bytes[b] ^ frame(i)[b]));
            EXPECT_LE(bits, 1);
            changed += bits;
        }
    }
    EXPECT_EQ(static_cast<std::uint64_t>(changed), channel.counts().corrupted);
    expect_share(channel.counts().corrupted, 0.4, frames);
}

TEST(Channel, DropsWhatItsFifoCannotHold) {
    for (const DropPolicy policy : {DropPolicy::oldest, DropPolicy::newest}) {
        Channel channel({.bandwidth_bps = 160'000, .fifo_events = 10, .drop_policy = policy});
        // One frame takes 1 ms and is on the line at once; then ten events may wait.
        for (int i = 0; i < 5; ++i) channel.send(at(0ms), frame(i), 4);
        EXPECT_EQ(channel.counts().dropped, 2U);
        const auto found = arrivals(channel);
        ASSERT_EQ(found.size(), 3U);
        EXPECT_EQ(found[1].number, policy == DropPolicy::oldest ? 3 : 1);
        EXPECT_EQ(found[2].number, policy == DropPolicy::oldest ? 4 : 2);
    }
}

// At 1 byte a millisecond each frame is 20 ms on the line. Nobody asks for arrivals meanwhile.
TEST(Channel, HasRoomAgainOnceAFrameIsOnItsWay) {
    Channel channel({.bandwidth_bps = 8000, .fifo_events = 1, .drop_policy = DropPolicy::newest});
    channel.send(at(0ms), frame(0), 1);
    channel.send(at(1ms), frame(1), 1);   // waits until 20 ms
    channel.send(at(19ms), frame(2), 1);  // no room
    channel.send(at(21ms), frame(3), 1);
    EXPECT_EQ(channel.counts().dropped, 1U);
    EXPECT_EQ(arrivals(channel), (std::vector<Arrival>{{at(20ms), 0}, {at(40ms), 1}, {at(60ms), 3}}));
}

TEST(Channel, KnowsHowManyBytesItHolds) {
    // One byte takes 1 ms.
    Channel channel({.bandwidth_bps = 8'000, .latency = 5ms});
    const auto holds = [&](std::size_t waiting, std::size_t all) {
        return channel.waiting_bytes() == waiting && channel.bytes() == all;
    };
    EXPECT_TRUE(holds(0, 0));
    channel.send(at(0ms), frame(0, 20), 1);
    EXPECT_TRUE(holds(0, 20)) << "it is being transmitted";
    channel.send(at(0ms), frame(1, 30), 1);
    channel.send(at(0ms), frame(2, 40), 1);
    EXPECT_TRUE(holds(70, 90));
    EXPECT_EQ(arrivals(channel, at(25ms)).size(), 1U);
    EXPECT_TRUE(holds(40, 70));
    EXPECT_EQ(arrivals(channel).size(), 2U);
    EXPECT_TRUE(holds(0, 0));
    EXPECT_TRUE(channel.empty());
    // The first is lost on its way, and the second waits for the line.
    Channel lossy({.bandwidth_bps = 8'000, .loss = 1});
    lossy.send(at(0ms), frame(0, 20), 1);
    lossy.send(at(0ms), frame(1, 20), 1);
    EXPECT_FALSE(lossy.empty());
    EXPECT_TRUE(arrivals(lossy).empty());
    EXPECT_TRUE(lossy.empty());
}

TEST(Channel, DeliversFramesThatArriveAtTheSameTimeInTheOrderTheyWereSent) {
    Channel channel({.latency = 5ms, .duplicate = 1});
    for (int i = 0; i < 3; ++i) channel.send(at(0ms), frame(i), 1);
    EXPECT_EQ(arrivals(channel),
              (std::vector<Arrival>{
                  {at(5ms), 0}, {at(5ms), 0}, {at(5ms), 1}, {at(5ms), 1}, {at(5ms), 2}, {at(5ms), 2}}));
}

TEST(Channel, IsTheSameForTheSameSeedHoweverItIsAsked) {
    const ChannelParameters parameters{.bandwidth_bps = 50'000,
                                       .latency = 2ms,
                                       .jitter = 4ms,
                                       .loss = 0.1,
                                       .reorder = 0.1,
                                       .duplicate = 0.1,
                                       .corrupt = 0.1};
    const auto at_the_end = run(parameters, 2000);
    Channel channel(parameters);
    std::vector<Arrival> piecewise;
    for (int i = 0; i < 2000; ++i) {
        channel.send(at(i * 5ms), frame(i), 1);
        for (const auto& arrival : arrivals(channel, at(i * 5ms + 3ms))) piecewise.push_back(arrival);
    }
    for (const auto& arrival : arrivals(channel)) piecewise.push_back(arrival);
    EXPECT_EQ(piecewise, at_the_end);
    ChannelParameters other = parameters;
    other.seed = 2;
    EXPECT_NE(run(other, 2000), at_the_end);
}

TEST(Channel, NamesTheParameterThatIsWrong) {
    EXPECT_THROW(Channel({.loss = 1.01}), ParameterError);
    EXPECT_THROW(Channel({.corrupt = std::nan("")}), ParameterError);
    EXPECT_THROW(Channel({.bandwidth_bps = -1}), ParameterError);
    EXPECT_THROW(Channel({.latency = -1ns}), ParameterError);
}

}  // namespace
}  // namespace afferent
