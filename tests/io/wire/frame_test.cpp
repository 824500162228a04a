#include "afferent/io/wire/frame.hpp"

#include <gtest/gtest.h>
#ifdef __x86_64__
#include <cpuid.h>
#endif

#include <cstring>
#include <random>
#include <string_view>

#include "afferent/io/wire/checksum.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;

Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

proto::Envelope some_packet() {
    proto::Envelope packet;
    packet.set_position(4711);
    packet.set_count(1000);
    packet.set_payload("\x05\x03spikes");
    return packet;
}

proto::Envelope some_hello() {
    proto::Envelope message;
    message.mutable_hello()->set_version(1);
    message.mutable_hello()->add_patch()->set_name("thumb");
    return message;
}

// Feeds all bytes, in pieces of that size; collects what comes out.
struct Outcome {
    std::vector<std::string> messages;
    std::vector<Error> errors;
    FrameCounts counts;
    bool lost = false;
};

Outcome read_all(std::span<const std::byte> bytes, std::size_t piece) {
    FrameReader reader;
    Outcome outcome;
    proto::Envelope message;
    while (!bytes.empty() && !reader.lost()) {
        const auto space = reader.space();
        const std::size_t count = std::min({piece, bytes.size(), space.size()});
        std::memcpy(space.data(), bytes.data(), count);
        reader.filled(count);
        bytes = bytes.subspan(count);
        for (;;) {
            const Result<bool> next = reader.next(message);
            if (!next) {
                outcome.errors.push_back(next.error());
                if (reader.lost()) break;
            } else if (next.value()) {
                outcome.messages.push_back(message.SerializeAsString());
            } else {
                break;
            }
        }
    }
    outcome.counts = reader.counts();
    outcome.lost = reader.lost();
    return outcome;
}

TEST(Checksum, IsTheOneOfIscsi) {
    // RFC 3720, appendix B.4, and the check value of the CRC catalogues.
    EXPECT_EQ(crc32c(Bytes(32, std::byte{0})), 0x8a9136aaU);
    EXPECT_EQ(crc32c(Bytes(32, std::byte{0xff})), 0x62a8ab43U);
    EXPECT_EQ(crc32c(std::as_bytes(std::span(std::string_view("123456789")))), 0xe3069283U);
}

#ifdef __x86_64__
// XINUSE: the parts of the processor's state that are not in their initial configuration. Call it only if
// tells_parts_in_use().
__attribute__((target("xsave"))) std::uint64_t parts_in_use() { return __builtin_ia32_xgetbv(1); }

bool tells_parts_in_use() {
    unsigned a = 0, b = 0, c = 0, d = 0;
    return __get_cpuid_count(0xd, 1, &a, &b, &c, &d) != 0 && (a & 4) != 0;
}

TEST(Checksum, LeavesNoUpperPartOfAVectorRegisterInUse) {
    if (!tells_parts_in_use())
        GTEST_SKIP() << "the processor does not tell which parts of its state are in use";
    constexpr std::uint64_t upper_parts = 0x44;  // of 256 and of 512 bits
    for (const std::size_t size : {16, 100, 1000, 100'000}) {
        const Bytes bytes(size, std::byte{1});
        (void)crc32c(bytes);
        EXPECT_EQ(parts_in_use() & upper_parts, 0U) << size;
    }
}
#endif

TEST(Frame, ComesBackFromAStreamHoweverItIsCut) {
    FrameWriter writer;
    Bytes stream;
    std::vector<std::string> sent;
    proto::Envelope large = some_packet();
    large.set_payload(std::string(100'000, 'x'));
    for (int i = 0; i < 20; ++i)
        for (const auto& message : {some_packet(), some_hello(), large}) {
            const auto frame = writer.stream_frame(message);
            stream.insert(stream.end(), frame.begin(), frame.end());
            sent.push_back(message.SerializeAsString());
        }
    for (const std::size_t piece : {1UL, 7UL, 1000UL, 1UL << 20}) {
        const Outcome outcome = read_all(stream, piece);
        EXPECT_EQ(outcome.messages, sent);
        EXPECT_TRUE(outcome.errors.empty());
        EXPECT_EQ(outcome.counts.bytes, stream.size());
        EXPECT_EQ(outcome.counts.frames, sent.size());
    }
}

TEST(Frame, WithAnyBitChangedIsNotDelivered) {
    FrameWriter writer;
    for (const auto& message : {some_packet(), some_hello()}) {
        const Bytes datagram = copy(writer.datagram(message));
        const Bytes frame = copy(writer.stream_frame(message));
        for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
            Bytes changed = frame;
            changed[bit / 8] ^= std::byte{1} << (bit % 8);
            EXPECT_TRUE(read_all(changed, 1000).messages.empty());
        }
        for (std::size_t bit = 0; bit < datagram.size() * 8; ++bit) {
            Bytes changed = datagram;
            changed[bit / 8] ^= std::byte{1} << (bit % 8);
            FrameCounts counts;
            proto::Envelope read;
            EXPECT_FALSE(read_datagram(changed, read, counts));
            EXPECT_EQ(counts.checksum_failures, 1U);
        }
    }
}

TEST(Frame, TruncatedIsNotDelivered) {
    FrameWriter writer;
    const Bytes frame = copy(writer.stream_frame(some_packet()));
    const Bytes datagram = copy(writer.datagram(some_packet()));
    for (std::size_t length = 0; length < frame.size(); ++length) {
        const Outcome outcome = read_all(std::span(frame).first(length), 1000);
        EXPECT_TRUE(outcome.messages.empty());
        EXPECT_TRUE(outcome.errors.empty());
    }
    for (std::size_t length = 0; length < datagram.size(); ++length) {
        FrameCounts counts;
        proto::Envelope read;
        EXPECT_FALSE(read_datagram(std::span(datagram).first(length), read, counts));
    }
}

TEST(Frame, ThatIsBrokenDoesNotHideTheNext) {
    FrameWriter writer;
    Bytes stream = copy(writer.stream_frame(some_packet()));
    stream[5] ^= std::byte{1};
    const auto next = writer.stream_frame(some_hello());
    stream.insert(stream.end(), next.begin(), next.end());
    const Outcome outcome = read_all(stream, 1000);
    ASSERT_EQ(outcome.errors.size(), 1U);
    EXPECT_EQ(outcome.errors[0].kind, Error::Kind::checksum);
    EXPECT_EQ(outcome.counts.checksum_failures, 1U);
    EXPECT_EQ(outcome.messages.size(), 1U);
}

TEST(Frame, ClaimingTooMuchIsRefusedBeforeItIsRead) {
    for (const Bytes& stream :
         {Bytes(3, std::byte{0xff}), Bytes{std::byte{0x81}, std::byte{0x80}, std::byte{0x10}}}) {
        const Outcome outcome = read_all(stream, 1);
        EXPECT_TRUE(outcome.lost);
        ASSERT_EQ(outcome.errors.size(), 1U);
        EXPECT_NE(outcome.errors[0].text.find("262144 bytes allowed"), std::string::npos);
    }
}

Bytes with_checksum(Bytes body) {
    const std::uint32_t checksum = crc32c(body);
    for (int i = 0; i < 4; ++i) body.push_back(static_cast<std::byte>(checksum >> (8 * i)));
    return body;
}

// A good checksum proves that the sender meant the message, not that it makes sense.
TEST(Frame, WithAGoodChecksumIsStillCheckedForSense) {
    FrameWriter writer;
    const auto refused = [&](const std::string& body) {
        const Bytes datagram = with_checksum(copy(std::as_bytes(std::span(body))));
        FrameCounts counts;
        proto::Envelope read;
        const bool good = read_datagram(datagram, read, counts).has_value();
        EXPECT_EQ(counts.refused, good ? 0U : 1U);
        return !good;
    };
    EXPECT_FALSE(refused(some_packet().SerializeAsString()));
    EXPECT_TRUE(refused(""));
    EXPECT_TRUE(refused("not a message"));
    // Neither of a packet's fields belongs to another message.
    for (const auto& add : {+[](proto::Envelope& message) { message.set_position(1); },
                            +[](proto::Envelope& message) { message.set_spans(1); },
                            +[](proto::Envelope& message) { message.set_part(1); },
                            +[](proto::Envelope& message) { message.set_more(true); },
                            +[](proto::Envelope& message) { message.set_count(0); },
                            +[](proto::Envelope& message) { message.set_begin(0); },
                            +[](proto::Envelope& message) { message.set_payload("x"); }}) {
        proto::Envelope both = some_hello();
        EXPECT_FALSE(refused(both.SerializeAsString()));
        add(both);
        EXPECT_TRUE(refused(both.SerializeAsString())) << both.ShortDebugString();
    }
    // Field 100, a varint: at the top, and within a hello's patch.
    const std::string unknown = {'\xa0', '\x06', '\x01'};
    EXPECT_TRUE(refused(some_packet().SerializeAsString() + unknown));
    EXPECT_TRUE(refused(some_hello().SerializeAsString() + unknown));
    proto::Envelope nested = some_hello();
    ASSERT_TRUE(nested.mutable_hello()->mutable_patch(0)->ParseFromString(unknown));
    EXPECT_TRUE(refused(nested.SerializeAsString()));
}

TEST(Frame, SurvivesGarbage) {
    std::mt19937 random(1);
    for (int repeat = 0; repeat < 2000; ++repeat) {
        Bytes garbage(random() % 200);
        for (auto& byte : garbage) byte = static_cast<std::byte>(random());
        EXPECT_TRUE(read_all(garbage, 64).messages.empty());
    }
}

TEST(Frame, CountsFromNothing) {
    const FrameCounts counts;
    EXPECT_EQ(counts.bytes, 0U);
    EXPECT_EQ(counts.frames, 0U);
    EXPECT_EQ(counts.checksum_failures, 0U);
    EXPECT_EQ(counts.refused, 0U);
    EXPECT_EQ(counts.forged, 0U);
    EXPECT_EQ(counts.repeated, 0U);
}

// A message may have 256 KiB; a datagram adds four bytes of checksum. A writer does not write more.
TEST(Frame, OfADatagramIsLimitedToTheByte) {
    const auto read = [](std::size_t message_bytes) {
        proto::Envelope message = some_packet();
        const std::size_t others = message.ByteSizeLong() - message.payload().size();
        message.set_payload(
            std::string(message_bytes - others - 2, 'x'));  // a longer length takes two bytes more
        EXPECT_EQ(message.ByteSizeLong(), message_bytes);
        const std::string body = message.SerializeAsString();
        const Bytes datagram = with_checksum(copy(std::as_bytes(std::span(body))));
        FrameCounts counts;
        proto::Envelope back;
        return read_datagram(datagram, back, counts).has_value();
    };
    EXPECT_TRUE(read(262'144));
    EXPECT_FALSE(read(262'145));
}

}  // namespace
}  // namespace afferent
