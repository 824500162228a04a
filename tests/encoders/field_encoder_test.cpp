#include "afferent/encoders/field_encoder.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "afferent/encoders/sustained.hpp"

namespace afferent {
namespace {

// The drives that a scan of one element sets, by afferent.
using Drives = std::vector<std::pair<std::uint32_t, double>>;

Drives take(FieldEncoder<Sustained>& encoder, Address element, double force_n) {
    const Scan scan{scene_start, element, {&force_n, 1}};
    Drives drives;
    encoder.take({&scan, 1}, [&](std::size_t i, double drive_mv) { drives.emplace_back(i, drive_mv); });
    return drives;
}

// Two afferents of four, whose neighbours read the same elements; the patch begins at the address 10.
TEST(FieldEncoder, DrivesItsOwnAfferentsAlone) {
    const ReceptiveFields fields(
        4, {{{1, 1}, {2, 1}, {3, 1}}, {{1, 1}, {2, 2}}, {{3, 3}}, {{1, 1}, {2, 1}, {3, 1}}});
    FieldEncoder<Sustained> encoder(Sustained({.gain_mv_per_n = 10, .bias_mv = 5}), fields, 10, 1, 2);
    ASSERT_EQ(encoder.size(), 2U);
    EXPECT_EQ(take(encoder, 11, 0.5), (Drives{{0, 5 + 10 * 0.5}}));
    EXPECT_EQ(take(encoder, 12, 1), (Drives{{0, 5 + 10 * (0.5 + 2 * 1)}}));
    EXPECT_EQ(take(encoder, 13, 2), (Drives{{1, 5 + 10 * 3 * 2.0}}));
    EXPECT_EQ(take(encoder, 10, 1), Drives()) << "it is read by none";
}

TEST(FieldEncoder, ForgetsOnResetWhatItsAfferentsHaveFelt) {
    const ReceptiveFields fields(2, {{{0, 1}, {1, 1}}, {{1, 1}}});
    FieldEncoder<Sustained> encoder(Sustained({.gain_mv_per_n = 10, .bias_mv = 5}), fields, 0, 0, 2);
    EXPECT_EQ(take(encoder, 0, 1), (Drives{{0, 5 + 10 * 1.0}}));
    Drives drives;
    encoder.reset([&](std::size_t i, double drive_mv) { drives.emplace_back(i, drive_mv); });
    EXPECT_EQ(drives, (Drives{{0, 5}, {1, 5}}));
    EXPECT_EQ(take(encoder, 1, 2), (Drives{{0, 5 + 10 * 2.0}, {1, 5 + 10 * 2.0}}));
}

TEST(FieldEncoder, KnowsItsSizeBeforeItIsBuilt) {
    const ReceptiveFields fields(
        4, {{{1, 1}, {2, 1}, {3, 1}}, {{1, 1}, {2, 2}}, {{3, 3}}, {{1, 1}, {2, 1}, {3, 1}}});
    for (std::uint32_t first = 0; first < 4; ++first)
        for (std::uint32_t count = 1; first + count <= 4; ++count)
            EXPECT_EQ(
                FieldEncoder<Sustained>::size_of(fields, first, count),
                FieldEncoder<Sustained>(Sustained({.gain_mv_per_n = 10}), fields, 10, first, count).bytes())
                << first << ", " << count;
}

}  // namespace
}  // namespace afferent
