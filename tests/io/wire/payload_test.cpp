#include "afferent/io/wire/payload.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace afferent {
namespace {

std::span<const std::byte> bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

PacketLayout layout_of(Address addresses, Encoding encoding) {
    PacketLayout layout;
    layout.addresses = addresses;
    layout.encoding = encoding;
    layout.max_events = 20'000;
    return layout;
}

std::vector<Code> random_codes(std::mt19937_64& random, std::size_t count, std::uint64_t codes_in_span) {
    std::uniform_int_distribution<std::uint64_t> any(0, codes_in_span - 1);
    std::vector<Code> codes(count);
    for (Code& code : codes) code = static_cast<Code>(any(random));
    std::sort(codes.begin(), codes.end());
    return codes;
}

void expect_identity(PayloadCodec& codec, const std::vector<Code>& codes) {
    std::string payload;
    codec.encode(codes, payload);
    const auto decoded = codec.decode(bytes(payload));
    ASSERT_TRUE(decoded) << decoded.error().text;
    EXPECT_TRUE(std::equal(codes.begin(), codes.end(), decoded.value().begin(), decoded.value().end()));
}

// As many codes as the spans of the packet have, and no more.
TEST(Payload, TakesTheCodesOfItsOwnSpans) {
    for (const Encoding encoding : {Encoding::rice, Encoding::fixed_width}) {
        PacketLayout layout = layout_of(9, encoding);
        layout.span = 1ms;
        layout.gathered_spans = 5;
        PayloadCodec codec(layout);
        std::string payload;
        codec.encode(std::vector<Code>{89}, payload, 1);
        EXPECT_TRUE(codec.decode(bytes(payload), 1));
        codec.encode(std::vector<Code>{90}, payload, 2);
        ASSERT_TRUE(codec.decode(bytes(payload), 2));
        EXPECT_EQ(codec.decode(bytes(payload), 2).value().front(), 90U);
        codec.encode(std::vector<Code>{180}, payload, 3);
        EXPECT_FALSE(codec.decode(bytes(payload), 1)) << "it has 90";
    }
}

// The fewer spans, the shorter the gaps: k is by the packet's own number of codes.
TEST(Payload, IsAsShortAsThatOfASessionWithSuchSpans) {
    std::mt19937_64 random(12);
    PacketLayout gathering = layout_of(1000, Encoding::rice);
    gathering.span = 1ms;
    gathering.gathered_spans = 5;
    PacketLayout alone = gathering;
    alone.gathered_spans = 1;
    for (const std::size_t count : {1U, 7U, 500U}) {
        const auto codes = random_codes(random, count, alone.codes());
        std::string in_one, by_itself;
        PayloadCodec(gathering).encode(codes, in_one, 1);
        PayloadCodec(alone).encode(codes, by_itself);
        EXPECT_EQ(in_one, by_itself);
    }
}

// For any events, spread or in one volley, the encoder takes the shorter of two codings.
TEST(PayloadBound, HoldsForEveryNumberOfEvents) {
    std::mt19937_64 random(4);
    for (const Encoding encoding : {Encoding::rice, Encoding::fixed_width})
        for (const Address addresses : {1U, 9U, 1000U, 100'000U, 85'899'345U})
            for (const std::size_t most : {1U, 2U, 100U, 3000U, 20'000U}) {
                PacketLayout layout = layout_of(addresses, encoding);
                layout.max_events = static_cast<std::uint32_t>(most);
                PayloadCodec codec(layout);
                std::string payload;
                std::size_t longest = 0;
                for (const std::size_t count : {most, most / 2 + 1, most / 8 + 1}) {
                    std::vector<Code> evenly(count);
                    for (std::size_t i = 0; i < count; ++i)
                        evenly[i] = static_cast<Code>(((i + 1) * layout.codes() - 1) / count);
                    for (const auto& codes :
                         {random_codes(random, count, layout.codes()), evenly, std::vector<Code>(count, 0),
                          std::vector<Code>(count, static_cast<Code>(layout.codes() - 1))}) {
                        codec.encode(codes, payload);
                        longest = std::max(longest, payload.size());
                    }
                }
                EXPECT_LE(longest, PayloadCodec::most_bytes(layout)) << addresses << " " << most;
                // And is not far off, so that it refuses nothing that fits.
                EXPECT_GT(static_cast<double>(longest) + 8,
                          0.8 * static_cast<double>(PayloadCodec::most_bytes(layout)))
                    << addresses << " " << most;
            }
}

class Payload : public testing::TestWithParam<Encoding> {};
INSTANTIATE_TEST_SUITE_P(Encodings, Payload, testing::Values(Encoding::rice, Encoding::fixed_width));

TEST_P(Payload, IsReadBackAsItWasWritten) {
    std::mt19937_64 random(1);
    for (const Address addresses : {1U, 2U, 9U, 1000U, 100'000U, 85'899'345U}) {
        const PacketLayout layout = layout_of(addresses, GetParam());
        PayloadCodec codec(layout);
        for (const std::size_t count : {0, 1, 2, 3, 10, 100, 1000, 20'000})
            for (int repeat = 0; repeat < 5; ++repeat)
                expect_identity(codec, random_codes(random, count, layout.codes()));
    }
}

TEST_P(Payload, HoldsVolleysTiesAndTheExtremeCodes) {
    const PacketLayout layout = layout_of(85'899'345, GetParam());
    PayloadCodec codec(layout);
    const auto last = static_cast<Code>(layout.codes() - 1);
    expect_identity(codec, {0});
    expect_identity(codec, {last});
    expect_identity(codec, {0, last});
    expect_identity(codec, {7, 7, 7, 7});
    expect_identity(codec, std::vector<Code>(20'000, last));
    std::vector<Code> volley;
    for (Code code = 4'000'000'000; code < 4'000'000'100; ++code) volley.push_back(code);
    expect_identity(codec, volley);
    volley.insert(volley.begin(), 0);
    expect_identity(codec, volley);
}

TEST_P(Payload, RefusesEveryTruncationAndEveryTrailingByte) {
    std::mt19937_64 random(2);
    const PacketLayout layout = layout_of(9, GetParam());
    PayloadCodec codec(layout);
    std::string payload;
    for (const std::size_t count : {1, 2, 5, 50, 400}) {
        codec.encode(random_codes(random, count, layout.codes()), payload);
        for (std::size_t length = 1; length < payload.size(); ++length) {
            const auto decoded = codec.decode(bytes(payload).first(length));
            // Whole codes of fixed width are a payload; that some are missing shows in the packet's checksum.
            EXPECT_EQ(decoded.has_value(), GetParam() == Encoding::fixed_width && length % 2 == 0);
        }
        for (const char trailing : {'\0', '\1', '\xff'})
            EXPECT_FALSE(codec.decode(bytes(payload + trailing)));
    }
}

// For any bytes: no crash, and a payload that is accepted could have come from encode().
TEST_P(Payload, SurvivesRandomAndChangedBytes) {
    std::mt19937_64 random(3);
    for (const Address addresses : {1U, 9U, 1000U, 85'899'345U}) {
        const PacketLayout layout = layout_of(addresses, GetParam());
        PayloadCodec codec(layout);
        const auto expect_harmless = [&](const std::string& payload) {
            const auto decoded = codec.decode(bytes(payload));
            if (!decoded) return;
            const auto codes = decoded.value();
            EXPECT_TRUE(std::is_sorted(codes.begin(), codes.end()));
            EXPECT_TRUE(codes.empty() || codes.back() < layout.codes());
            EXPECT_LE(codes.size(), layout.max_events);
        };
        std::string payload;
        for (int repeat = 0; repeat < 20'000; ++repeat) {
            payload.resize(random() % 40);
            for (char& byte : payload) byte = static_cast<char>(random());
            expect_harmless(payload);
        }
        codec.encode(random_codes(random, 30, layout.codes()), payload);
        for (std::size_t bit = 0; bit < payload.size() * 8; ++bit) {
            std::string changed = payload;
            changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << (bit % 8)));
            expect_harmless(changed);
        }
    }
}

TEST(RicePayload, RefusesClaimsThatItsLengthCannotHold) {
    PayloadCodec codec(layout_of(9, Encoding::rice));
    const auto refusal = [&](std::string payload) {
        const auto decoded = codec.decode(bytes(payload));
        return decoded ? std::string() : decoded.error().text;
    };
    EXPECT_NE(refusal({'\0'}).find("claims no events"), std::string::npos);
    EXPECT_NE(refusal({'\x06', '\x01'}).find("shorter than the events it claims"), std::string::npos);
    EXPECT_NE(refusal({'\xff', '\xff', '\x02'}).find("more events than the session"), std::string::npos);
    EXPECT_NE(refusal({'\xff', '\xff', '\xff', '\x02'}).find("more events than any"), std::string::npos);
    EXPECT_NE(refusal({'\x03', ' ', '\x01'}).find("no such Rice parameter"), std::string::npos);
    EXPECT_NE(refusal({'\x03', '\0', '\0', '\0', '\0'}).find("ends within a gap"), std::string::npos);
}

// Poisson spikes of independent neurons: the information in the numbers of events per code, against the bytes
// that they take.
TEST(RicePayload, IsCloseToTheEntropyOfPoissonSpikes) {
    std::mt19937_64 random(4);
    for (const Address addresses : {1000U, 100'000U})
        for (const Duration tick : {Duration(100us), Duration(1ms)}) {
            PacketLayout layout = layout_of(addresses, Encoding::rice);
            layout.tick = tick;
            PayloadCodec codec(layout);
            const double per_code = 20.0 * seconds(tick);
            const double codes = static_cast<double>(layout.codes());
            double entropy_bits = 0;  // of one code: −Σ p log2 p over the Poisson distribution
            double p = std::exp(-per_code);
            for (int events = 0; events < 20; ++events, p *= per_code / events)
                if (p > 0) entropy_bits -= p * std::log2(p);
            double sent_bits = 0;
            std::poisson_distribution<int> count(per_code * codes);
            std::string payload;
            const int packets = addresses == 1000 ? 2000 : 50;
            for (int packet = 0; packet < packets; ++packet) {
                codec.encode(random_codes(random, static_cast<std::size_t>(count(random)), layout.codes()),
                             payload);
                sent_bits += 8.0 * static_cast<double>(payload.size());
            }
            const double ratio = sent_bits / (entropy_bits * codes * packets);
            // Rice coding costs up to 0.9 % at these gaps, the header and the last byte 3 bytes in 90 and
            // more.
            EXPECT_LT(ratio, addresses == 1000 ? 1.045 : 1.011)
                << addresses << " addresses, tick " << tick.count();
            EXPECT_GT(ratio, 1.0);
        }
}

}  // namespace
}  // namespace afferent
