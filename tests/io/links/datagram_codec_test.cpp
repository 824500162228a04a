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

constexpr Responder::Time now{};

Bytes frame_of(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

// Both ends of a session that has been opened.
struct Ends {
    explicit Ends(const SecretKey& key) {
        const Initiator initiator(key);
        Responder responder(key);
        const Bytes reply = responder.reply(initiator.request(), now).value();
        connector = initiator.answered_by(reply).value();
        connector.wrap(frame_of("hello"), first);
        listener = std::move(responder.accept(first, now)->codec);
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
    Responder responder(key_);
    EXPECT_FALSE(responder.reply(Initiator(std::nullopt).request(), now));           // plain to sealed
    EXPECT_FALSE(Responder(std::nullopt).reply(Initiator(key_).request(), now));     // and the reverse
    EXPECT_FALSE(responder.reply(Initiator(SecretKey::generate()).request(), now));  // another key
    const Bytes request = copy(Initiator(key_).request());
    for (std::size_t byte = 0; byte < request.size(); ++byte) {
        EXPECT_FALSE(responder.reply(with_byte_changed(request, byte), now));
        EXPECT_FALSE(responder.reply(std::span(request).first(byte), now));
    }
    EXPECT_TRUE(responder.reply(request, now));
}

TEST_F(SealedHandshake, BelievesNoReplyButItsOwn) {
    Responder responder(key_);
    const Initiator initiator(key_);
    const Initiator other(key_);
    const Bytes reply = responder.reply(initiator.request(), now).value();
    EXPECT_FALSE(other.answered_by(reply));
    EXPECT_FALSE(
        initiator.answered_by(Responder(std::nullopt).reply(Initiator(std::nullopt).request(), now).value()));
    EXPECT_FALSE(Initiator(std::nullopt).answered_by(reply));
    EXPECT_FALSE(initiator.answered_by(initiator.request()));
    for (std::size_t byte = 0; byte < reply.size(); ++byte) {
        EXPECT_FALSE(initiator.answered_by(with_byte_changed(reply, byte)));
        EXPECT_FALSE(initiator.answered_by(std::span(reply).first(byte)));
    }
    EXPECT_TRUE(initiator.answered_by(reply));
}

// The whole of an old session, recorded and sent again: every request gets a reply, and that is all.
TEST_F(SealedHandshake, LetsNobodyInWithARecording) {
    Responder responder(key_);
    std::vector<Bytes> recording;
    for (int session = 0; session < 3; ++session) {
        const Initiator initiator(key_);
        recording.push_back(copy(initiator.request()));
        DatagramCodec codec =
            initiator.answered_by(responder.reply(initiator.request(), now).value()).value();
        for (const char* text : {"hello", "packet", "bye"}) recording.push_back(wrapped(codec, text));
        ASSERT_TRUE(responder.accept(recording[recording.size() - 3], now));
    }
    int replies = 0;
    for (int round = 0; round < 10; ++round)
        for (const Bytes& datagram : recording) {
            replies += responder.reply(datagram, now) ? 1 : 0;
            EXPECT_FALSE(responder.accept(datagram, now));
        }
    EXPECT_EQ(replies, 30);
    // And who has the key still comes in.
    const Initiator initiator(key_);
    DatagramCodec codec = initiator.answered_by(responder.reply(initiator.request(), now).value()).value();
    EXPECT_TRUE(responder.accept(wrapped(codec, "hello"), now));
}

// Somebody keeps back the first data of a handshake, to open a session with it when nobody is there, or to
// end one.
TEST_F(SealedHandshake, ForgetsARequestWithTimeAndWhenAnotherIsAccepted) {
    Responder responder(key_);
    const auto first_data = [&] {
        const Initiator initiator(key_);
        DatagramCodec codec =
            initiator.answered_by(responder.reply(initiator.request(), now).value()).value();
        return wrapped(codec, "hello");
    };
    EXPECT_FALSE(
        responder.accept(first_data(), now + Responder::longest_wait + std::chrono::milliseconds(1)));
    const Bytes kept_back = first_data();
    EXPECT_TRUE(responder.accept(first_data(), now));
    EXPECT_FALSE(responder.accept(kept_back, now));
}

TEST_F(SealedHandshake, GivesTheSameRequestTheSameReplyAndRemembersOnlySoMany) {
    Responder responder(key_);
    const Initiator first(key_);
    const Bytes reply = responder.reply(first.request(), now).value();
    EXPECT_EQ(responder.reply(first.request(), now), reply);
    DatagramCodec codec = first.answered_by(reply).value();
    for (std::size_t i = 1; i < Responder::most_waiting; ++i)
        (void)responder.reply(Initiator(key_).request(), now);
    EXPECT_EQ(responder.reply(first.request(), now), reply);
    (void)responder.reply(Initiator(key_).request(), now);
    EXPECT_NE(responder.reply(first.request(), now), reply);
    EXPECT_FALSE(responder.accept(wrapped(codec, "hello"), now));
}

}  // namespace
}  // namespace afferent
