#include "afferent/studies/trial/tally.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {

void Tally::add(const Presentation& presentation) {
    ++presentations_;
    broken_ += presentation.outcome == Outcome::broken;
    dropped_ += presentation.outcome == Outcome::dropped;
    safe_state_ += presentation.safe_state;
    slips_ += presentation.slip_onset_s.has_value();
    if (presentation.slip_reaction_s) reactions_s_.push_back(*presentation.slip_reaction_s);
    peak_sum_n_ += presentation.peak_force_n;
}

std::optional<double> Tally::reaction_s(double part) const {
    if (reactions_s_.empty()) return std::nullopt;
    std::vector<double> sorted = reactions_s_;
    const auto rank =
        static_cast<std::size_t>(std::max(1.0, std::ceil(part * static_cast<double>(sorted.size()))));
    const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::ranges::nth_element(sorted, place);
    return *place;
}

Tallies tally(std::span<const Presentation> presentations) {
    Tallies tallies;
    for (const Presentation& each : presentations)
        (each.slippery ? tallies.slippery : tallies.delicate).add(each);
    return tallies;
}

PairedCount paired(std::span<const Presentation> first, std::span<const Presentation> second,
                   const std::function<bool(const Presentation&)>& counts) {
    PairedCount count;
    auto other = second.begin();
    for (const Presentation& one : first) {
        while (other != second.end() && other->number < one.number) ++other;
        if (other != second.end() && other->number == one.number) count.add(counts(one), counts(*other));
    }
    return count;
}

}  // namespace afferent
