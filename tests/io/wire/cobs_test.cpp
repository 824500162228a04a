#include "afferent/io/wire/cobs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace afferent {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes(std::initializer_list<int> values) {
    Bytes made;
    for (const int value : values) made.push_back(std::byte(value));
    return made;
}

Bytes encoded(const Bytes& datagram) {
    Bytes line;
    append_cobs(datagram, line);
    return line;
}

std::vector<Bytes> read(CobsReader& reader, const Bytes& line, std::size_t at_once = 1) {
    std::vector<Bytes> datagrams;
    for (std::size_t i = 0; i < line.size(); i += at_once)
        reader.read(std::span(line).subspan(i, std::min(at_once, line.size() - i)),
                    [&](auto datagram) { datagrams.emplace_back(datagram.begin(), datagram.end()); });
    return datagrams;
}

// Datagrams with every kind of block: empty, short, full, and full followed by a zero.
std::vector<Bytes> some_datagrams() {
    std::mt19937 random(1);
    std::vector<Bytes> datagrams{bytes({0}), bytes({1}), bytes({0, 0}), bytes({0, 1, 0}), bytes({255})};
    for (const std::size_t size : {253, 254, 255, 256, 508, 509, 510, 1000})
        for (const int zero_at : {-1, 0, 252, 253, 254, 255, 507, 508})
            for (const bool random_fill : {false, true}) {
                Bytes datagram(size, std::byte{7});
                if (random_fill)
                    for (std::byte& byte : datagram) byte = std::byte(random() % 4);
                if (zero_at >= 0 && static_cast<std::size_t>(zero_at) < size)
                    datagram[static_cast<std::size_t>(zero_at)] = std::byte{0};
                datagrams.push_back(std::move(datagram));
            }
    return datagrams;
}

// The examples of the article, between the zeros that begin and end each.
TEST(Cobs, WritesWhatOthersRead) {
    EXPECT_EQ(encoded(bytes({0})), bytes({0, 1, 1, 0}));
    EXPECT_EQ(encoded(bytes({0, 0})), bytes({0, 1, 1, 1, 0}));
    EXPECT_EQ(encoded(bytes({0x11, 0x22, 0, 0x33})), bytes({0, 3, 0x11, 0x22, 2, 0x33, 0}));
    EXPECT_EQ(encoded(bytes({0x11, 0, 0, 0})), bytes({0, 2, 0x11, 1, 1, 1, 0}));
    // A full block of 254 ends the datagram without another.
    const Bytes full(254, std::byte{9});
    Bytes line = encoded(full);
    EXPECT_EQ(line.size(), 257U);
    EXPECT_EQ(line[1], std::byte{255});
}

TEST(Cobs, GivesBackEveryDatagramHoweverTheBytesCome) {
    Bytes line;
    const std::vector<Bytes> datagrams = some_datagrams();
    for (const Bytes& datagram : datagrams) append_cobs(datagram, line);
    for (const std::size_t at_once : {1, 2, 7, 4096}) {
        CobsReader reader(1000);
        EXPECT_EQ(read(reader, line, at_once), datagrams);
        EXPECT_EQ(reader.refused(), 0U);
    }
}

TEST(Cobs, CostsThreeBytesAndOneFor254) {
    for (const Bytes& datagram : some_datagrams()) {
        const Bytes line = encoded(datagram);
        EXPECT_LE(line.size(), datagram.size() + 3 + datagram.size() / 254);
        EXPECT_EQ(std::count(line.begin(), line.end(), std::byte{0}), 2);
    }
}

TEST(Cobs, FindsTheNextDatagramAfterAnyGarbage) {
    std::mt19937 random(2);
    for (int i = 0; i < 1000; ++i) {
        Bytes line(random() % 600);
        for (std::byte& byte : line) byte = std::byte(random());
        const Bytes good = bytes({1, 0, 2});
        append_cobs(good, line);
        CobsReader reader(300);
        const auto datagrams = read(reader, line, 64);
        ASSERT_FALSE(datagrams.empty());
        EXPECT_EQ(datagrams.back(), good);
    }
}

TEST(Cobs, RefusesWhatIsCutShort) {
    const Bytes line = encoded(Bytes(300, std::byte{5}));
    for (std::size_t kept = 2; kept + 1 < line.size(); ++kept) {
        Bytes cut(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(kept));
        cut.push_back(std::byte{0});
        CobsReader reader(1000);
        // Where a block happens to end there, it is a shorter datagram: for the tag to find out.
        const auto datagrams = read(reader, cut);
        EXPECT_EQ(datagrams.size() + reader.refused(), 1U) << kept;
        for (const Bytes& datagram : datagrams) EXPECT_EQ(datagram.size(), 254U);
    }
}

TEST(Cobs, HoldsNoMoreThanTheLongestDatagram) {
    CobsReader reader(100);
    Bytes line = encoded(Bytes(101, std::byte{5}));
    line.insert(line.end(), 1'000'000, std::byte{1});
    line.push_back(std::byte{0});
    append_cobs(Bytes(100, std::byte{0}), line);
    const auto datagrams = read(reader, line, 1000);
    EXPECT_EQ(datagrams, std::vector<Bytes>{Bytes(100, std::byte{0})});
    EXPECT_EQ(reader.refused(), 2U);
}

TEST(Cobs, MakesNothingOfRepeatedZeros) {
    CobsReader reader(100);
    EXPECT_TRUE(read(reader, Bytes(50, std::byte{0})).empty());
    EXPECT_EQ(reader.refused(), 0U);
}

TEST(Cobs, ReadsEveryDatagramIntoTheMemoryThatItWasMadeWith) {
    CobsReader reader(1000);
    Bytes line = encoded(bytes({1}));
    append_cobs(Bytes(1000, std::byte{5}), line);
    std::vector<const std::byte*> places;
    reader.read(line, [&](auto datagram) { places.push_back(datagram.data()); });
    ASSERT_EQ(places.size(), 2U);
    EXPECT_EQ(places[0], places[1]) << "the longest would not fit where the shortest was";
}

}  // namespace
}  // namespace afferent
