#include "afferent/io/pictures/population_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "afferent/io/pictures/figure.hpp"

namespace afferent {

PopulationRows::PopulationRows(const Population& population, double direction_deg) {
    const double direction = direction_deg * std::numbers::pi / 180;
    for (const Population::Patch& patch : population.patches) {
        auto kind = std::ranges::find(kinds_, patch.kind, &Kind::name);
        if (kind == kinds_.end()) kind = kinds_.insert(kind, {patch.kind, 0, 0});
        kind->rows += patch.afferents;
        kind_.insert(kind_.end(), patch.afferents, static_cast<std::uint8_t>(kind - kinds_.begin()));
    }
    for (std::size_t i = 1; i < kinds_.size(); ++i)
        kinds_[i].first = kinds_[i - 1].first + kinds_[i - 1].rows;
    row_.resize(kind_.size());
    afferents_.resize(kind_.size());
    along_mm_.resize(kind_.size(), std::numeric_limits<double>::quiet_NaN());

    std::vector<Positions> positions(kinds_.size());
    for (Address address = 0; address < population.afferents.size(); ++address)
        if (const auto& at = population.afferents[address].place)
            positions[kind_[address]].emplace_back(
                address, at->x_mm * std::cos(direction) + at->y_mm * std::sin(direction));
    std::vector<std::uint32_t> next;  // row of each kind for an afferent without a position
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
        place(positions[i], kinds_[i].first);
        next.push_back(kinds_[i].first + static_cast<std::uint32_t>(positions[i].size()));
    }
    for (Address address = 0; address < row_.size(); ++address) {
        if (address >= population.afferents.size() || !population.afferents[address].place)
            row_[address] = next[kind_[address]]++;
        ++afferents_[row_[address]];
    }
}

void PopulationRows::place(const Positions& positions, std::uint32_t first) {
    if (positions.empty()) return;
    const auto [first_of_all, last_of_all] =
        std::ranges::minmax_element(positions, {}, &Positions::value_type::second);
    const double smallest = first_of_all->second;
    const double largest = last_of_all->second;
    const double steps = static_cast<double>(positions.size()) - 1;
    const double step_mm = steps > 0 ? (largest - smallest) / steps : 0;
    for (std::uint32_t i = 0; i < positions.size(); ++i) along_mm_[first + i] = largest - i * step_mm;
    for (const auto& [address, along_mm] : positions)
        row_[address] =
            first +
            (step_mm > 0 ? static_cast<std::uint32_t>(std::lround((largest - along_mm) / step_mm)) : 0);
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
