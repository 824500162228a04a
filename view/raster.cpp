#include "afferent/view/raster.hpp"

#include <algorithm>
#include <array>

namespace afferent {
namespace {

std::vector<RasterLayout::Afferents> afferents_of(const Plan& plan) {
    std::vector<RasterLayout::Afferents> patches;
    for (const PatchPlan& patch : plan.patches) patches.push_back({patch.name, patch.afferents()});
    return patches;
}

}  // namespace

RasterLayout::RasterLayout(const Plan& plan) : RasterLayout(afferents_of(plan)) {}

RasterLayout::RasterLayout(const std::vector<Afferents>& patches) {
    std::uint64_t all = 0;
    for (const Afferents& patch : patches) all += patch.count;
    const bool too_many = patches.size() > most_rows;
    // One row is every patch's own; the rest is shared out by size.
    const std::uint64_t to_share = too_many ? 0 : most_rows - patches.size();
    std::uint64_t before = 0;
    for (const Afferents& patch : patches) {
        std::uint32_t rows = 1 + static_cast<std::uint32_t>(all ? to_share * patch.count / all : 0);
        std::uint32_t first = rows_;
        if (all <= most_rows) {
            rows = patch.count;
        } else if (too_many) {
            first = static_cast<std::uint32_t>(before * most_rows / all);
            rows = 1;
        }
        rows = std::min(rows, patch.count);
        patches_.push_back({patch.name, patch.count, first, rows});
        for (std::uint64_t i = 0; i < patch.count; ++i) {
            const std::uint64_t row =
                too_many ? (before + i) * most_rows / all : first + i * rows / patch.count;
            row_.push_back(static_cast<std::uint8_t>(row));
        }
        rows_ = too_many ? most_rows : first + rows;
        before += patch.count;
    }
    constexpr std::array<int, 5> bins_ms{1, 2, 5, 10, 20};
    const auto* const bin_ms = std::ranges::find_if(bins_ms, [&](int ms) {
        return rows_ * 1000 <= most_cells_per_second * static_cast<std::uint32_t>(ms);
    });
    bin_ = std::chrono::milliseconds(bin_ms == bins_ms.end() ? bins_ms.back() : *bin_ms);
}

RasterBins::RasterBins(const RasterLayout& layout) : layout_(layout) {
    run_.counts.resize(static_cast<std::size_t>(span / layout.bin()) * layout.rows());
}

void RasterBins::begin(TimePoint time) {
    const std::int64_t spans = (time - scene_start) / span - ((time - scene_start) % span < Duration::zero());
    const TimePoint begin = scene_start + spans * span;
    run_.first_bin = spans * (span / layout_.bin());
    std::ranges::fill(run_.counts, 0);
    counting_ = true;
    end_ = begin + span;
    bin_end_ = begin + layout_.bin();
    column_ = 0;
}

}  // namespace afferent
