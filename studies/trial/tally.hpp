// What came of many presentations: how many objects broke or were dropped, and how soon the hand answered a
// slip.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "afferent/studies/trial/presentation.hpp"
#include "afferent/studies/trial/proportion_interval.hpp"

namespace afferent {

class Tally {
  public:
    void add(const Presentation& presentation);

    std::uint64_t presentations() const noexcept { return presentations_; }
    Proportion broken() const noexcept { return {broken_, presentations_}; }
    Proportion dropped() const noexcept { return {dropped_, presentations_}; }
    Proportion failed() const noexcept { return {broken_ + dropped_, presentations_}; }
    // Presentations in which the link was silent for too long.
    Proportion safe_state() const noexcept { return {safe_state_, presentations_}; }

    // From the contact until the hand is told of it, as answer_s() of those of which it is.
    std::optional<double> told_s(double part) const;
    // Contacts that the hand answered.
    std::uint64_t answers() const noexcept { return answers_s_.size(); }
    // From the contact to the command that answers it: the least time that so many of those that were
    // answered do not exceed, with `part` in [0, 1]. None where no contact was.
    std::optional<double> answer_s(double part) const;

    // Presentations in which the object began to slip.
    std::uint64_t slips() const noexcept { return slips_; }
    // Slips that the hand answered.
    std::uint64_t reactions() const noexcept { return reactions_s_.size(); }
    // From the onset of a slip to the hand's reaction: the least time that so many of the answered slips do
    // not exceed, with `part` in [0, 1]. None where no slip was answered.
    std::optional<double> reaction_s(double part) const;

    // Slips that ended before the object was lost.
    Proportion stopped() const noexcept { return {slips_ - lost_, slips_}; }
    // How far the objects that slipped have slipped; as reaction_s().
    std::optional<double> slipped_mm(double part) const;
    // Presentations in which the hand began a closing pulse before anything slipped.
    Proportion false_pulses() const noexcept { return {falsely_pulsed_, presentations_}; }

    // The largest force of each presentation, in the mean. NaN without a presentation.
    double mean_peak_n() const noexcept { return peak_sum_n_ / static_cast<double>(presentations_); }

  private:
    std::uint64_t presentations_ = 0;
    std::uint64_t broken_ = 0;
    std::uint64_t dropped_ = 0;
    std::uint64_t safe_state_ = 0;
    std::uint64_t slips_ = 0;
    std::uint64_t lost_ = 0;  // of the slips
    std::uint64_t falsely_pulsed_ = 0;
    std::vector<double> told_s_;
    std::vector<double> answers_s_;
    std::vector<double> reactions_s_;
    std::vector<double> slipped_mm_;
    double peak_sum_n_ = 0;
};

// Delicate objects, which break, and slippery ones, which slip instead, counted apart.
struct Tallies {
    Tally delicate;
    Tally slippery;
    // Among all presentations, because a pulse without a slip may break a delicate object.
    Proportion false_pulses() const noexcept {
        const auto [of_delicate, delicate_count] = delicate.false_pulses();
        const auto [of_slippery, slippery_count] = slippery.false_pulses();
        return {of_delicate + of_slippery, delicate_count + slippery_count};
    }
};
Tallies tally(std::span<const Presentation> presentations);

// The presentations that both conditions have, by their numbers, which increase.
PairedCount paired(std::span<const Presentation> first, std::span<const Presentation> second,
                   const std::function<bool(const Presentation&)>& counts);
// The part of the delicate objects that breaks under the second condition less that under the first.
std::optional<Estimated> broken_difference(std::span<const Presentation> first,
                                           std::span<const Presentation> second);

}  // namespace afferent
