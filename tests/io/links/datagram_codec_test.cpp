// What someone without the key can do to sealed datagrams, and what not.
#include "afferent/io/links/datagram_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>

#include "afferent/io/wire/frame.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;
using Unwrapped = DatagramCodec::Unwrapped;

DatagramCodec::Time clock_now{};

Bytes frame_of(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

// Both ends of a session that has been opened.
struct Ends {
    Ends(const SecretKey& to_listener, const SecretKey& to_connector)
        : connector(to_listener, to_connector, clock_now), listener(to_connector, to_listener, clock_now) {}

    DatagramCodec connector;
    DatagramCodec listener;
};

Bytes wrapped(DatagramCodec& codec, const std::string& text) {
    Bytes datagram;
    codec.wrap(frame_of(text), datagram, clock_now);
    return datagram;
}

class SealedDatagrams : public testing::Test {
  protected:
    SealedDatagrams() { clock_now = {}; }

    Unwrapped unwrap(DatagramCodec& codec, const Bytes& datagram) {
        return codec.unwrap(datagram, frame_, clock_now);
    }

    Ends ends_{SecretKey::generate(), SecretKey::generate()};
    Bytes frame_;
};

// A nonce that came twice would give both plaintexts away: the difference of what is sealed would be theirs.
TEST_F(SealedDatagrams, HaveANonceOfTheirOwn) {
    constexpr std::size_t header = 2;  // the kind with the number of the key, and the counter
    constexpr std::size_t text = 6;
    std::set<Bytes> sealed;
    for (int i = 0; i < 100; ++i) {
        const Bytes datagram = wrapped(ends_.connector, "events");
        ASSERT_GT(datagram.size(), header + text);
        sealed.insert(Bytes(datagram.begin() + header, datagram.begin() + header + text));
    }
    EXPECT_EQ(sealed.size(), 100U);
}

TEST_F(SealedDatagrams, AreReadByTheOtherEndInBothDirections) {
    EXPECT_EQ(unwrap(ends_.listener, wrapped(ends_.connector, "events")), Unwrapped::good);
    EXPECT_EQ(frame_, frame_of("events"));
    EXPECT_EQ(unwrap(ends_.connector, wrapped(ends_.listener, "status")), Unwrapped::good);
    EXPECT_EQ(frame_, frame_of("status"));
    EXPECT_EQ(unwrap(ends_.listener, wrapped(ends_.connector, "")), Unwrapped::good);
    EXPECT_TRUE(frame_.empty());
}

TEST_F(SealedDatagrams, CostEighteenBytesAtFirstAndNeverMoreThanTheirShare) {
    EXPECT_EQ(wrapped(ends_.connector, "").size(), 18U);
    for (int i = 0; i < 200; ++i) (void)wrapped(ends_.connector, "");
    EXPECT_EQ(wrapped(ends_.connector, "").size(), 19U);
}

TEST_F(SealedDatagrams, ShowNothingOfWhatTheyHold) {
    const Bytes datagram = wrapped(ends_.connector, std::string(64, 'a'));
    const Bytes again = wrapped(ends_.connector, std::string(64, 'a'));
    EXPECT_FALSE(std::equal(datagram.begin() + 2, datagram.end(), again.begin() + 2));
}

TEST_F(SealedDatagrams, CountOnlyOnceInWhateverOrderTheyCome) {
    const Bytes first = wrapped(ends_.connector, "1");
    const Bytes second = wrapped(ends_.connector, "2");
    const Bytes third = wrapped(ends_.connector, "3");
    EXPECT_EQ(unwrap(ends_.listener, second), Unwrapped::good);
    EXPECT_EQ(unwrap(ends_.listener, second), Unwrapped::repeated);
    EXPECT_EQ(unwrap(ends_.listener, first), Unwrapped::overtaken);
    EXPECT_EQ(frame_, frame_of("1"));
    EXPECT_EQ(unwrap(ends_.listener, first), Unwrapped::repeated);
    EXPECT_EQ(unwrap(ends_.listener, third), Unwrapped::good);
}

TEST_F(SealedDatagrams, MayBeOvertakenByAsManyAsTheWindowHolds) {
    std::vector<Bytes> sent;
    for (std::size_t i = 0; i < ReplayWindow::width + 1; ++i) sent.push_back(wrapped(ends_.connector, "x"));
    EXPECT_EQ(unwrap(ends_.listener, sent.back()), Unwrapped::good);
    EXPECT_EQ(unwrap(ends_.listener, sent[0]), Unwrapped::repeated);
    std::shuffle(sent.begin() + 1, sent.end() - 1, std::mt19937(1));
    for (std::size_t i = 1; i + 1 < sent.size(); ++i)
        EXPECT_EQ(unwrap(ends_.listener, sent[i]), Unwrapped::overtaken);
    for (const Bytes& datagram : sent) EXPECT_EQ(unwrap(ends_.listener, datagram), Unwrapped::repeated);
}

// Against the plainest description of what may be taken.
TEST(ReplayWindow, TakesEachNumberOnceAndNoneThatIsTooOld) {
    std::mt19937 random(2);
    ReplayWindow window;
    std::set<std::uint64_t> taken;
    std::uint64_t newest = 0;
    EXPECT_FALSE(window.is_new(0));
    for (int i = 0; i < 100'000; ++i) {
        const std::uint64_t step = random() % 1000 == 0 ? 1000 : random() % 8;
        const std::uint64_t number =
            random() % 3 == 0 ? newest + step : newest - std::min<std::uint64_t>(newest, random() % 200);
        const bool expected = number > 0 && number + ReplayWindow::width > newest && taken.count(number) == 0;
        ASSERT_EQ(window.is_new(number), expected) << number << " after " << newest;
        if (!expected) continue;
        ASSERT_EQ(window.take(number), number > newest);
        taken.insert(number);
        newest = std::max(newest, number);
    }
}

// The keys change under traffic in both directions, and nothing is lost.
TEST_F(SealedDatagrams, GetNewKeysEveryTwoMinutes) {
    Bytes before = wrapped(ends_.connector, "old");
    const std::byte first_key = before.at(0);
    for (int step = 0; step < 1000; ++step) {
        clock_now += 1s;
        ASSERT_EQ(unwrap(ends_.listener, wrapped(ends_.connector, "up")), Unwrapped::good);
        ASSERT_EQ(unwrap(ends_.connector, wrapped(ends_.listener, "down")), Unwrapped::good);
    }
    // 8 times in 1,000 s; and each begins to count at 1.
    EXPECT_EQ(std::to_integer<int>(wrapped(ends_.connector, "")[0]), std::to_integer<int>(first_key) + 8);
    EXPECT_EQ(wrapped(ends_.connector, "").size(), 18U);
    EXPECT_EQ(unwrap(ends_.listener, before), Unwrapped::forged);
}

TEST_F(SealedDatagrams, GetNewKeysAfterAMillionOfThem) {
    Bytes datagram;
    Bytes first;
    std::size_t longest = 0;
    for (std::uint64_t i = 0; i < DatagramCodec::most_datagrams_of_a_key + 3; ++i) {
        ends_.connector.wrap({}, datagram, clock_now);
        if (first.empty()) first = datagram;
        longest = std::max(longest, datagram.size());
        ASSERT_EQ(unwrap(ends_.listener, datagram), Unwrapped::good);
    }
    EXPECT_EQ(std::to_integer<int>(datagram[0]), std::to_integer<int>(first[0]) + 1);
    EXPECT_EQ(longest, longest_seal_bytes);
}

TEST_F(SealedDatagrams, OfTheOldKeyAreTakenForAWhile) {
    const Bytes overtaken = wrapped(ends_.connector, "overtaken");
    const Bytes late = wrapped(ends_.connector, "late");
    clock_now += DatagramCodec::longest_use_of_a_key;
    const Bytes newer = wrapped(ends_.connector, "newer");
    EXPECT_NE(newer.at(0), late.at(0));
    EXPECT_EQ(unwrap(ends_.listener, newer), Unwrapped::good);
    EXPECT_EQ(unwrap(ends_.listener, overtaken), Unwrapped::overtaken);
    EXPECT_EQ(unwrap(ends_.listener, overtaken), Unwrapped::repeated);
    clock_now += DatagramCodec::grace_of_a_key;
    EXPECT_EQ(unwrap(ends_.listener, late), Unwrapped::forged);
}

// Anyone may name any key: none is used before a datagram proves it.
TEST_F(SealedDatagrams, ChangeNoKeyUnlessTheyAreAuthentic) {
    const Bytes good = wrapped(ends_.connector, "events");
    for (int key = 0; key < 64; ++key) {
        Bytes forged = good;
        forged[0] = std::byte(64 + (std::to_integer<int>(good.at(0)) - 64 + 1 + key) % 64);
        if (forged[0] == good.at(0)) continue;
        EXPECT_EQ(unwrap(ends_.listener, forged), Unwrapped::forged);
    }
    EXPECT_EQ(unwrap(ends_.listener, good), Unwrapped::good);
}

TEST(KeyChain, NeverGivesAKeyTwiceAndIsTheSameAtBothEnds) {
    const SecretKey secret = SecretKey::generate();
    KeyChain one(secret);
    KeyChain other(secret);
    std::vector<SecretKey> keys{secret};
    for (int i = 0; i < 50; ++i) {
        const SecretKey key = one.next_key();
        EXPECT_EQ(key, other.next_key());
        EXPECT_EQ(std::count(keys.begin(), keys.end(), key), 0);
        keys.push_back(key);
    }
}

TEST_F(SealedDatagrams, AreRefusedWithAnyBitChanged) {
    const Bytes good = wrapped(ends_.connector, "events");
    for (std::size_t byte = 0; byte < good.size(); ++byte)
        for (int bit = 0; bit < 8; ++bit) {
            Bytes changed = good;
            changed[byte] ^= std::byte(1 << bit);
            EXPECT_EQ(unwrap(ends_.listener, changed), Unwrapped::forged) << byte << " " << bit;
        }
    EXPECT_EQ(unwrap(ends_.listener, good), Unwrapped::good);
}

TEST_F(SealedDatagrams, AreRefusedCutShortAnywhereOrGrown) {
    Bytes datagram = wrapped(ends_.connector, "events");
    for (std::size_t kept = 0; kept < datagram.size(); ++kept)
        EXPECT_EQ(unwrap(ends_.listener,
                         Bytes(datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(kept))),
                  Unwrapped::forged);
    datagram.push_back(std::byte{0});
    EXPECT_EQ(unwrap(ends_.listener, datagram), Unwrapped::forged);
}

TEST_F(SealedDatagrams, AreOfOneDirectionAndOneSession) {
    const Bytes datagram = wrapped(ends_.connector, "events");
    EXPECT_EQ(unwrap(ends_.connector, datagram), Unwrapped::forged);  // sent back to its sender
    Ends other(SecretKey::generate(), SecretKey::generate());
    EXPECT_EQ(unwrap(other.listener, datagram), Unwrapped::forged);
    EXPECT_EQ(unwrap(ends_.listener, frame_of("events")), Unwrapped::forged);  // plain
}

TEST_F(SealedDatagrams, WithACounterThatNeverEndsAreRefused) {
    Bytes endless(100, std::byte{0xff});
    endless[0] = std::byte{64};
    EXPECT_EQ(unwrap(ends_.listener, endless), Unwrapped::forged);
    std::mt19937 random(1);
    for (int i = 0; i < 100'000; ++i) {
        Bytes garbage(random() % 80);
        for (std::byte& byte : garbage) byte = std::byte(random());
        if (!garbage.empty()) garbage[0] = std::byte{64};
        ASSERT_EQ(unwrap(ends_.listener, garbage), Unwrapped::forged);
    }
}

TEST(PlainDatagrams, AreFramesAndSignsOfLife) {
    DatagramCodec codec;
    Bytes frame;
    EXPECT_EQ(wrapped(codec, "frame"), frame_of("frame"));
    EXPECT_EQ(codec.unwrap(frame_of("frame"), frame, clock_now), Unwrapped::good);
    EXPECT_EQ(frame, frame_of("frame"));
    EXPECT_EQ(codec.unwrap(wrapped(codec, ""), frame, clock_now), Unwrapped::good);
    EXPECT_TRUE(frame.empty());
}

}  // namespace
}  // namespace afferent
