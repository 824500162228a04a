// What can be done to sealed datagrams by somebody without the key, and what cannot.
#include "afferent/io/links/datagram_codec.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "afferent/io/links/datagram_handshake.hpp"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;
using Unwrapped = DatagramCodec::Unwrapped;

constexpr Door::Time now{};

Bytes frame_of(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

// Both ends of a session that has been opened.
struct Ends {
    explicit Ends(const SecretKey& key) {
        const Knock knock(key);
        Door door(key);
        const Bytes reply = door.reply(knock.datagram(), now).value();
        connector = knock.answered_by(reply).value();
        connector.wrap(frame_of("hello"), first);
        listener = std::move(door.entry(first, now)->codec);
    }

    DatagramCodec connector;
    DatagramCodec listener;
    Bytes first;
};

Bytes wrapped(DatagramCodec& codec, const std::string& text) {
    Bytes datagram;
    codec.wrap(frame_of(text), datagram);
    return datagram;
}

class SealedDatagrams : public testing::Test {
  protected:
    Unwrapped unwrap(DatagramCodec& codec, const Bytes& datagram) { return codec.unwrap(datagram, frame_); }

    SecretKey key_ = SecretKey::generate();
    Ends ends_{key_};
    Bytes frame_;
};

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

TEST_F(SealedDatagrams, CountOnlyOnce) {
    const Bytes first = wrapped(ends_.connector, "1");
    const Bytes second = wrapped(ends_.connector, "2");
    const Bytes third = wrapped(ends_.connector, "3");
    EXPECT_EQ(unwrap(ends_.listener, second), Unwrapped::good);
    EXPECT_EQ(unwrap(ends_.listener, second), Unwrapped::repeated);
    EXPECT_EQ(unwrap(ends_.listener, first), Unwrapped::repeated);  // overtaken
    EXPECT_EQ(unwrap(ends_.listener, third), Unwrapped::good);
    EXPECT_EQ(unwrap(ends_.listener, ends_.first), Unwrapped::repeated);
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

TEST_F(SealedDatagrams, AreOfOneDirectionOneSessionAndOneKey) {
    const Bytes datagram = wrapped(ends_.connector, "events");
    EXPECT_EQ(unwrap(ends_.connector, datagram), Unwrapped::forged);  // sent back to its sender
    Ends other_session(key_);
    EXPECT_EQ(unwrap(other_session.listener, datagram), Unwrapped::forged);
    Ends other_key(SecretKey::generate());
    EXPECT_EQ(unwrap(other_key.listener, datagram), Unwrapped::forged);
    EXPECT_EQ(unwrap(ends_.listener, frame_of("events")), Unwrapped::forged);  // plain
}

TEST_F(SealedDatagrams, WithACounterThatNeverEndsAreRefused) {
    Bytes endless(100, std::byte{0xff});
    endless[0] = std::byte{3};
    EXPECT_EQ(unwrap(ends_.listener, endless), Unwrapped::forged);
    std::mt19937 random(1);
    for (int i = 0; i < 100'000; ++i) {
        Bytes garbage(random() % 80);
        for (std::byte& byte : garbage) byte = std::byte(random());
        if (!garbage.empty()) garbage[0] = std::byte{3};
        ASSERT_EQ(unwrap(ends_.listener, garbage), Unwrapped::forged);
    }
}

TEST(PlainDatagrams, AreFramesAndSignsOfLife) {
    DatagramCodec codec;
    Bytes frame;
    EXPECT_EQ(wrapped(codec, "frame"), frame_of("frame"));
    EXPECT_EQ(codec.unwrap(frame_of("frame"), frame), Unwrapped::good);
    EXPECT_EQ(frame, frame_of("frame"));
    EXPECT_EQ(codec.unwrap(wrapped(codec, ""), frame), Unwrapped::good);
    EXPECT_TRUE(frame.empty());
}

class SealedHandshake : public testing::Test {
  protected:
    static Bytes with_byte_changed(Bytes datagram, std::size_t byte) {
        datagram[byte] ^= std::byte{1};
        return datagram;
    }
    static Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

    SecretKey key_ = SecretKey::generate();
};

TEST_F(SealedHandshake, AnswersNobodyWithoutTheKey) {
    Door door(key_);
    EXPECT_FALSE(door.reply(Knock(std::nullopt).datagram(), now));           // plain to sealed
    EXPECT_FALSE(Door(std::nullopt).reply(Knock(key_).datagram(), now));     // and the reverse
    EXPECT_FALSE(door.reply(Knock(SecretKey::generate()).datagram(), now));  // another key
    const Bytes knock = copy(Knock(key_).datagram());
    for (std::size_t byte = 0; byte < knock.size(); ++byte) {
        EXPECT_FALSE(door.reply(with_byte_changed(knock, byte), now));
        EXPECT_FALSE(door.reply(std::span(knock).first(byte), now));
    }
    EXPECT_TRUE(door.reply(knock, now));
}

TEST_F(SealedHandshake, BelievesNoReplyButItsOwn) {
    Door door(key_);
    const Knock knock(key_);
    const Knock other(key_);
    const Bytes reply = door.reply(knock.datagram(), now).value();
    EXPECT_FALSE(other.answered_by(reply));
    EXPECT_FALSE(knock.answered_by(Door(std::nullopt).reply(Knock(std::nullopt).datagram(), now).value()));
    EXPECT_FALSE(Knock(std::nullopt).answered_by(reply));
    EXPECT_FALSE(knock.answered_by(knock.datagram()));
    for (std::size_t byte = 0; byte < reply.size(); ++byte) {
        EXPECT_FALSE(knock.answered_by(with_byte_changed(reply, byte)));
        EXPECT_FALSE(knock.answered_by(std::span(reply).first(byte)));
    }
    EXPECT_TRUE(knock.answered_by(reply));
}

// The whole of an old session, recorded and sent again: every knock gets a reply, and that is all.
TEST_F(SealedHandshake, LetsNobodyInWithARecording) {
    Door door(key_);
    std::vector<Bytes> recording;
    for (int session = 0; session < 3; ++session) {
        const Knock knock(key_);
        recording.push_back(copy(knock.datagram()));
        DatagramCodec codec = knock.answered_by(door.reply(knock.datagram(), now).value()).value();
        for (const char* text : {"hello", "packet", "bye"}) recording.push_back(wrapped(codec, text));
        ASSERT_TRUE(door.entry(recording[recording.size() - 3], now));
    }
    int replies = 0;
    for (int round = 0; round < 10; ++round)
        for (const Bytes& datagram : recording) {
            replies += door.reply(datagram, now) ? 1 : 0;
            EXPECT_FALSE(door.entry(datagram, now));
        }
    EXPECT_EQ(replies, 30);
    // And who has the key still comes in.
    const Knock knock(key_);
    DatagramCodec codec = knock.answered_by(door.reply(knock.datagram(), now).value()).value();
    EXPECT_TRUE(door.entry(wrapped(codec, "hello"), now));
}

// Somebody keeps back the first data of a handshake, to open a session with it when nobody is there, or to
// end one.
TEST_F(SealedHandshake, ForgetsAKnockWithTimeAndWhenAnotherHasComeIn) {
    Door door(key_);
    const auto first_data = [&] {
        const Knock knock(key_);
        DatagramCodec codec = knock.answered_by(door.reply(knock.datagram(), now).value()).value();
        return wrapped(codec, "hello");
    };
    EXPECT_FALSE(door.entry(first_data(), now + Door::longest_wait + std::chrono::milliseconds(1)));
    const Bytes kept_back = first_data();
    EXPECT_TRUE(door.entry(first_data(), now));
    EXPECT_FALSE(door.entry(kept_back, now));
}

TEST_F(SealedHandshake, GivesTheSameKnockTheSameReplyAndRemembersOnlySoMany) {
    Door door(key_);
    const Knock first(key_);
    const Bytes reply = door.reply(first.datagram(), now).value();
    EXPECT_EQ(door.reply(first.datagram(), now), reply);
    DatagramCodec codec = first.answered_by(reply).value();
    for (std::size_t i = 1; i < Door::most_waiting; ++i) (void)door.reply(Knock(key_).datagram(), now);
    EXPECT_EQ(door.reply(first.datagram(), now), reply);
    (void)door.reply(Knock(key_).datagram(), now);
    EXPECT_NE(door.reply(first.datagram(), now), reply);
    EXPECT_FALSE(door.entry(wrapped(codec, "hello"), now));
}

}  // namespace
}  // namespace afferent
