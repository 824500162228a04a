#include "afferent/io/pictures/population_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "afferent/io/pictures/figure.hpp"

namespace afferent {

PopulationRows::PopulationRows(const Population& population, double direction_deg) {
    const double direction = direction_deg * std::numbers::pi / 180;
    std::vector<double> along;
    for (const Population::Patch& patch : population.patches) {
        auto kind = std::ranges::find(kinds_, patch.kind, &Kind::name);
        if (kind == kinds_.end()) kind = kinds_.insert(kind, {patch.kind, 0, 0});
        kind->rows += patch.afferents;
        kind_.insert(kind_.end(), patch.afferents, static_cast<std::uint8_t>(kind - kinds_.begin()));
    }
    for (std::size_t i = 1; i < kinds_.size(); ++i)
        kinds_[i].first = kinds_[i - 1].first + kinds_[i - 1].rows;
    for (const Population::Afferent& each : population.afferents)
        along.push_back(each.place
                            ? each.place->x_mm * std::cos(direction) + each.place->y_mm * std::sin(direction)
                            : std::numeric_limits<double>::quiet_NaN());
    along.resize(kind_.size(), std::numeric_limits<double>::quiet_NaN());

    std::vector<std::uint32_t> order(kind_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        if (kind_[a] != kind_[b]) return kind_[a] < kind_[b];
        if (std::isnan(along[a]) || std::isnan(along[b]))
            return !std::isnan(along[a]) && std::isnan(along[b]);
        return along[a] < along[b];
    });
    row_.resize(order.size());
    for (std::uint32_t row = 0; row < order.size(); ++row) {
        row_[order[row]] = row;
        along_mm_.push_back(along[order[row]]);
    }
}

std::string_view colour_of_kind(const std::vector<PopulationRows::Kind>& kinds, std::size_t kind) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 3> common{
        {{"SA1", colour::green}, {"RA", colour::blue}, {"PC", colour::vermilion}}};
    constexpr std::array others{colour::orange, colour::purple, colour::sky, colour::brown, colour::black};
    std::size_t rest = 0;
    for (std::size_t i = 0; i <= kind; ++i) {
        const auto* found =
            std::ranges::find(common, kinds[i].name, [](const auto& each) { return each.first; });
        if (i == kind && found != common.end()) return found->second;
        if (i < kind && found == common.end()) ++rest;
    }
    return others[rest % others.size()];
}

}  // namespace afferent
