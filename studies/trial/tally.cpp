#include "afferent/studies/trial/tally.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace afferent {
namespace {

std::optional<double> quantile(std::vector<double> of, double part) {
    if (of.empty()) return std::nullopt;
    const auto rank =
        static_cast<std::size_t>(std::max(1.0, std::ceil(part * static_cast<double>(of.size()))));
    const auto place = of.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::ranges::nth_element(of, place);
    return *place;
}

}  // namespace

void Tally::add(const Presentation& presentation) {
    ++presentations_;
    broken_ += presentation.outcome == Outcome::broken;
    dropped_ += presentation.outcome == Outcome::dropped;
    safe_state_ += presentation.safe_state;
    if (presentation.told_s) told_s_.push_back(*presentation.told_s);
    if (presentation.answer_s) answers_s_.push_back(*presentation.answer_s);
    falsely_pulsed_ += presentation.false_pulses > 0;
    if (presentation.slip_onset_s) {
        ++slips_;
        lost_ += presentation.outcome == Outcome::dropped;
        slipped_mm_.push_back(presentation.slipped_mm);
    }
    if (presentation.slip_reaction_s) reactions_s_.push_back(*presentation.slip_reaction_s);
    peak_sum_n_ += presentation.peak_force_n;
}

std::optional<double> Tally::told_s(double part) const { return quantile(told_s_, part); }
std::optional<double> Tally::answer_s(double part) const { return quantile(answers_s_, part); }
std::optional<double> Tally::reaction_s(double part) const { return quantile(reactions_s_, part); }
std::optional<double> Tally::slipped_mm(double part) const { return quantile(slipped_mm_, part); }

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

std::optional<Estimated> broken_difference(std::span<const Presentation> first,
                                           std::span<const Presentation> second) {
    const auto delicate = [](std::span<const Presentation> all) {
        std::vector<Presentation> those;
        std::ranges::copy_if(all, std::back_inserter(those), std::not_fn(&Presentation::slippery));
        return those;
    };
    return difference(paired(delicate(first), delicate(second),
                             [](const Presentation& one) { return one.outcome == Outcome::broken; }));
}

}  // namespace afferent
