#include "afferent/view/raster.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <random>
#include <set>

namespace afferent {
namespace {

using Patches = std::vector<RasterLayout::Afferents>;

// By bin and row.
using Cells = std::map<std::pair<std::int64_t, std::uint32_t>, std::uint64_t>;

class Collected {
  public:
    explicit Collected(const RasterLayout& layout) : layout_(layout) {}
    void operator()(const RasterRun& run) {
        ++runs;
        for (std::size_t i = 0; i < run.counts.size(); ++i) {
            sum += run.counts[i];
            const auto bin = run.first_bin + static_cast<std::int64_t>(i / layout_.rows());
            EXPECT_TRUE(bins.insert({bin, i % layout_.rows()}).second) << "told twice";
            if (run.counts[i] > 0)
                cells[{bin, static_cast<std::uint32_t>(i % layout_.rows())}] = run.counts[i];
        }
    }
    auto pass() {
        return [this](const RasterRun& run) { (*this)(run); };
    }

    Cells cells;
    std::set<std::pair<std::int64_t, std::size_t>> bins;
    std::uint64_t sum = 0;
    int runs = 0;

  private:
    const RasterLayout& layout_;
};

TEST(RasterLayout, GivesEveryAfferentOfASmallSceneARow) {
    const RasterLayout layout(Patches{{"thumb", 3}, {"index", 3}, {"middle", 3}});
    EXPECT_EQ(layout.rows(), 9U);
    EXPECT_EQ(layout.bin(), 1ms);
    for (Address address = 0; address < 9; ++address) EXPECT_EQ(layout.row(address), address);
    ASSERT_EQ(layout.patches().size(), 3U);
    EXPECT_EQ(layout.patches()[2].first_row, 6U);
}

TEST(RasterLayout, BoundsWhatASecondTakesWhateverTheScene) {
    const std::vector<Patches> scenes{
        {{"one", 1}},
        {{"a", 11}},
        {{"a", 100}, {"b", 1}},
        {{"a", 200}},
        {{"a", 201}},
        {{"large", 1'000'000}, {"small", 1}},
        Patches(150, {"many", 700}),
        Patches(5'000, {"very many", 20}),
    };
    for (const Patches& patches : scenes) {
        const RasterLayout layout(patches);
        ASSERT_EQ(layout.patches().size(), patches.size());
        EXPECT_LE(layout.rows(), 200U);
        EXPECT_LE(layout.rows() * (Duration(1s) / layout.bin()), 10'000U);
        EXPECT_EQ(RasterBins::span % layout.bin(), 0ns);
        // Rows follow each other without a hole, and belong to one patch where there are enough.
        std::uint32_t last = 0;
        Address address = 0;
        for (std::size_t i = 0; i < patches.size(); ++i) {
            const RasterLayout::Patch& patch = layout.patches()[i];
            for (std::uint32_t k = 0; k < patches[i].count; ++k) {
                const std::uint32_t row = layout.row(address++);
                ASSERT_LT(row, layout.rows());
                ASSERT_TRUE(row == last || row == last + 1) << patch.name << ' ' << k;
                last = row;
                if (patches.size() > RasterLayout::most_rows) continue;
                ASSERT_GE(row, patch.first_row);
                ASSERT_LT(row, patch.first_row + patch.rows);
            }
        }
        EXPECT_EQ(last, layout.rows() - 1);
        EXPECT_EQ(address, layout.addresses());
    }
}

TEST(RasterBins, LosesNoEventAndMisplacesNone) {
    const RasterLayout layout(Patches{{"a", 70'000}, {"b", 30'000}});
    RasterBins bins(layout);
    Collected collected(layout);
    std::mt19937_64 random(1);
    Cells expected;
    std::vector<Event> events;
    TimePoint now = scene_start + 3s;
    constexpr std::uint64_t count = 200'000;
    for (std::uint64_t i = 0; i < count; ++i) {
        // Now and then a silence that is longer than a bin, a span, or anything that is kept.
        const std::uint64_t dice = random() % 10'000;
        now += Duration(random() % 40'000) + (dice == 0 ? 5s : dice < 5 ? Duration(90ms) : Duration(0));
        const auto address = static_cast<Address>(random() % layout.addresses());
        events.push_back({now, address});
        ++expected[{(now - scene_start) / layout.bin(), layout.row(address)}];
        if (random() % 300 == 0 || dice == 6) {
            bins.add(events, collected.pass());
            events.clear();
        }
        if (dice == 6) bins.until(now - 1ms, collected.pass());
    }
    bins.add(events, collected.pass());
    bins.finish(collected.pass());
    EXPECT_EQ(collected.sum, count);
    EXPECT_EQ(collected.cells, expected);
}

TEST(RasterBins, TellsOfSilence) {
    const RasterLayout layout(Patches{{"a", 5}});
    RasterBins bins(layout);
    Collected collected(layout);
    for (int i = 0; i <= 100; ++i) bins.until(scene_start + i * 10ms, collected.pass());
    // A second is 25 spans of 40 ms, the last of which is not over.
    EXPECT_EQ(collected.runs, 25);
    EXPECT_EQ(collected.sum, 0U);
    EXPECT_EQ(collected.bins.size(), 1000U * 5);
}

TEST(RasterBins, CountsAnEventThatIsLate) {
    const RasterLayout layout(Patches{{"a", 5}});
    RasterBins bins(layout);
    Collected collected(layout);
    const std::vector<Event> events{{scene_start + 100ms, 0}, {scene_start + 20ms, 3}};
    bins.add(events, collected.pass());
    bins.finish(collected.pass());
    EXPECT_EQ(collected.sum, 2U);
}

TEST(RasterBins, PassesOverAddressesThatDoNotExist) {
    const RasterLayout layout(Patches{{"a", 5}});
    RasterBins bins(layout);
    Collected collected(layout);
    const std::vector<Event> events{{scene_start, 4}, {scene_start, 5}, {scene_start, ~Address{0}}};
    bins.add(events, collected.pass());
    bins.finish(collected.pass());
    EXPECT_EQ(collected.sum, 1U);
}

}  // namespace
}  // namespace afferent
