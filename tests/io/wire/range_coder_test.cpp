#include "afferent/io/wire/range_coder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace afferent {
namespace {

struct RangeSymbol {
    std::uint32_t low;
    std::uint32_t frequency;
    std::uint32_t total;

    double bits() const { return std::log2(static_cast<double>(total) / frequency); }
};

std::string ranged(const std::vector<RangeSymbol>& symbols) {
    std::string bytes = "what was here before";
    RangeEncoder encoder(bytes);
    for (const RangeSymbol& symbol : symbols) encoder.put(symbol.low, symbol.frequency, symbol.total);
    encoder.finish();
    return bytes;
}

void expect_back(const std::vector<RangeSymbol>& symbols, const std::string& bytes) {
    RangeDecoder decoder(std::as_bytes(std::span(bytes)));
    for (const RangeSymbol& symbol : symbols) {
        const std::uint32_t at = decoder.find(symbol.total);
        ASSERT_GE(at, symbol.low);
        ASSERT_LT(at, symbol.low + symbol.frequency);
        decoder.take(symbol.low, symbol.frequency);
    }
    EXPECT_TRUE(decoder.used_all());
}

TEST(RangeCoder, BringsBackWhatWasPutAtItsEntropy) {
    std::mt19937_64 random(1);
    for (int repetition = 0; repetition < 3000; ++repetition) {
        std::vector<RangeSymbol> symbols(random() % 200);
        double bits = 0;
        for (RangeSymbol& symbol : symbols) {
            // Of all sizes, so that some are nearly certain and some nearly impossible.
            symbol.total = 1 + static_cast<std::uint32_t>(random() % (std::uint64_t{1} << random() % 19));
            symbol.low = static_cast<std::uint32_t>(random() % symbol.total);
            symbol.frequency = 1 + static_cast<std::uint32_t>(random() % (symbol.total - symbol.low));
            bits += symbol.bits();
        }
        const std::string bytes = ranged(symbols);
        expect_back(symbols, bytes);
        // A part of the range is lost by rounding: at most a 64th for each symbol.
        EXPECT_LE(static_cast<double>(bytes.size()),
                  bits / 8 + static_cast<double>(symbols.size()) * std::log2(65.0 / 64) / 8 + 1.01);
    }
}

TEST(RangeCoder, HandsCarriesOn) {
    // Always the last part: the bytes are as near to the next higher as they can be.
    for (std::uint32_t last = 0; last < 40; ++last) {
        std::vector<RangeSymbol> symbols(100, {most_total - 1, 1, most_total});
        symbols.resize(100 + last, {1, 2, 3});
        symbols.push_back({0, 1, most_total});
        expect_back(symbols, ranged(symbols));
    }
}

TEST(RangeCoder, TakesNoBytesForWhatIsCertain) {
    EXPECT_EQ(ranged({}), "");
    EXPECT_EQ(ranged(std::vector<RangeSymbol>(1000, {0, 1, 1})), "");
    EXPECT_EQ(ranged({{0, 1, 2}}), "") << "zeros at the end are left out";
    EXPECT_EQ(ranged({{1, 1, 2}}).size(), 1U);
}

TEST(RangeCoder, KnowsOfBytesThatNoSymbolAskedFor) {
    const std::vector<RangeSymbol> symbols(10, {3, 1, 16});
    std::string bytes = ranged(symbols);
    expect_back(symbols, bytes);
    bytes.append(8, '\0');
    RangeDecoder decoder(std::as_bytes(std::span(bytes)));
    for (const RangeSymbol& symbol : symbols) {
        EXPECT_EQ(decoder.find(16), 3U);
        decoder.take(symbol.low, symbol.frequency);
    }
    EXPECT_FALSE(decoder.used_all());
}

}  // namespace
}  // namespace afferent
