#include "afferent/studies/trial/report.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "afferent/studies/trial/numbers.hpp"
#include "afferent/studies/trial/percent.hpp"
#include "afferent/studies/trial/published.hpp"
#include "afferent/studies/trial/tables.hpp"

namespace afferent {
namespace {

Summary in_ms(const std::optional<double>& time_s) { return time_s ? Summary(1e3 * *time_s) : Summary(); }

Summary summary_of_slips(const Tallies& tallies) {
    const Tally& tally = tallies.slippery;
    Summary summary{{"presentations", tally.presentations()}};
    add_percent(summary, "dropped", tally.dropped());
    summary["slips"] = tally.slips();
    summary["answered"] = tally.reactions();
    summary["reaction_p10_ms"] = in_ms(tally.reaction_s(0.1));
    summary["reaction_p50_ms"] = in_ms(tally.reaction_s(0.5));
    summary["reaction_p90_ms"] = in_ms(tally.reaction_s(0.9));
    summary["stopped_pct"] = known(percent(tally.stopped()));
    summary["slipped_p50_mm"] = tally.slips() > 0 ? Summary(*tally.slipped_mm(0.5)) : Summary();
    summary["false_pulses_pct"] = known(percent(tallies.false_pulses()));
    return summary;
}

const TrialRows* rows_of(const std::vector<TrialRows>& rows, std::string_view condition) {
    const auto found = std::ranges::find(rows, condition, &TrialRows::condition);
    return found == rows.end() ? nullptr : &*found;
}

bool is_dropped(const Presentation& one) { return one.outcome == Outcome::dropped; }
bool has_failed(const Presentation& one) { return !one.slippery && one.outcome != Outcome::held; }

// What the later experiment is compared with, in the same presentations.
std::optional<Estimated> failed_over_none(const std::vector<TrialRows>& rows) {
    const TrialRows* none = rows_of(rows, "none");
    const TrialRows* events = rows_of(rows, halved_condition);
    if (!none || !events || !none->paper) return std::nullopt;
    return ratio(paired(none->presentations, events->presentations, has_failed));
}

struct AgainstRate {
    std::string condition;
    Estimated broken;   // shares of the delicate objects
    Estimated dropped;  // and of all
};

// Each other decoder against the paper's, presentation by presentation.
std::vector<AgainstRate> against_rate(const std::vector<TrialRows>& rows) {
    std::vector<AgainstRate> compared;
    const TrialRows* rate = rows_of(rows, "rate");
    if (!rate) return compared;
    for (const TrialRows& other : rows) {
        if (other.condition == "none" || other.condition == "rate") continue;
        const auto broken = broken_difference(rate->presentations, other.presentations);
        const auto dropped = difference(paired(rate->presentations, other.presentations, is_dropped));
        if (broken && dropped) compared.push_back({other.condition, *broken, *dropped});
    }
    return compared;
}

std::string milliseconds(const std::optional<double>& time_s) {
    return time_s ? fixed(1e3 * *time_s, 0) : "-";
}

void print_conditions(const std::vector<TrialRows>& rows, std::ostream& out) {
    out << "Delicate objects\n\n"
        << std::left << std::setw(16) << "condition" << std::right << std::setw(14) << "presentations"
        << std::setw(10) << "broken %" << std::setw(15) << "95 %" << std::setw(11) << "dropped %"
        << std::setw(9) << "told ms" << std::setw(11) << "answer ms" << std::setw(12) << "10 to 90 %"
        << std::setw(13) << "the paper %" << std::setw(15) << "95 %"
        << "\n";
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        out << std::left << std::setw(16) << row.condition << std::right << std::setw(14)
            << tally.presentations() << std::setw(10) << fixed(percent(tally.broken()), 2) << std::setw(15)
            << range_of(tally.broken()) << std::setw(11) << fixed(percent(tally.dropped()), 2) << std::setw(9)
            << milliseconds(tally.told_s(0.5)) << std::setw(11) << milliseconds(tally.answer_s(0.5))
            << std::setw(12)
            << (tally.answer_s(0.5)
                    ? milliseconds(tally.answer_s(0.1)) + " to " + milliseconds(tally.answer_s(0.9))
                    : "-");
        if (const auto& found = row.paper)
            out << std::setw(13) << fixed(percent(found->broken), 1) << std::setw(15)
                << range_of(found->broken) << "  " << source_of(row);
        out << '\n';
    }
    out << "\ntold: from the contact until estimate or rate are above the highest before it, median; "
           "answer: until\nthe command is lower than what the EMG asks for, median\n";
}

void print_slips(const std::vector<TrialRows>& rows, std::ostream& out) {
    const bool any = std::ranges::any_of(
        rows, [](const TrialRows& row) { return row.tallies.slippery.presentations() > 0; });
    if (!any) return;
    out << "\nThe heavy object that slips; from the onset of a slip until a pulse or the gain lets the "
           "hand close further\n\n"
        << std::left << std::setw(16) << "condition" << std::right << std::setw(14) << "presentations"
        << std::setw(11) << "dropped %" << std::setw(15) << "95 %" << std::setw(9) << "slips" << std::setw(11)
        << "stopped %" << std::setw(6) << "mm" << std::setw(11) << "answered" << std::setw(12) << "median ms"
        << std::setw(8) << "10 %" << std::setw(8) << "90 %" << std::setw(16) << "false pulses %" << '\n';
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.slippery;
        out << std::left << std::setw(16) << row.condition << std::right << std::setw(14)
            << tally.presentations() << std::setw(11) << fixed(percent(tally.dropped()), 2) << std::setw(15)
            << range_of(tally.dropped()) << std::setw(9) << tally.slips() << std::setw(11)
            << (tally.slips() > 0 ? fixed(percent(tally.stopped()), 1) : "-") << std::setw(6)
            << (tally.slips() > 0 ? fixed(*tally.slipped_mm(0.5), 1) : "-") << std::setw(11)
            << tally.reactions() << std::setw(12) << milliseconds(tally.reaction_s(0.5)) << std::setw(8)
            << milliseconds(tally.reaction_s(0.1)) << std::setw(8) << milliseconds(tally.reaction_s(0.9))
            << std::setw(16) << fixed(percent(row.tallies.false_pulses()), 2) << '\n';
    }
    out << "\nmm: how far those have slipped, median; false pulses: of all presentations, those with a pulse "
           "before anything slips.\n"
           "The published 35 to 85 ms are of hands that detect a slip and close by themselves, as with "
           "gain { pulse {} }.\n";
}

// Force is fitted, and much of what moves it moves rate as well: free is how far the two are apart.
struct FreeDifference {
    Estimated ours, the_papers;
};
std::optional<FreeDifference> rate_less_force(const std::vector<TrialRows>& rows) {
    const TrialRows* force = rows_of(rows, "force");
    const TrialRows* rate = rows_of(rows, "rate");
    if (!force || !rate || !force->paper || !rate->paper) return std::nullopt;
    const auto ours = broken_difference(force->presentations, rate->presentations);
    const auto the_papers = difference(force->paper->broken, rate->paper->broken);
    if (!ours || !the_papers) return std::nullopt;
    return FreeDifference{*ours, *the_papers};
}

void print_free_difference(const std::vector<TrialRows>& rows, std::ostream& out) {
    const auto found = rate_less_force(rows);
    if (!found) return;
    out << "\nPredicted: how many more break with rate than with force, which is fitted. Here "
        << points(found->ours) << " points,\nin the paper " << points(found->the_papers)
        << " of 200 presentations each, whose interval "
        << (found->the_papers.interval.holds(found->ours.value) ? "holds that" : "does not hold that")
        << ".\n";
}

void print_predictions(const std::vector<TrialRows>& rows, std::ostream& out) {
    print_free_difference(rows, out);
    if (const auto found = failed_over_none(rows))
        out << "\nPredicted, and fitted to nothing: with " << halved_condition << ", broken and dropped are "
            << fixed(found->value, 3) << " (" << fixed(found->interval.low, 3) << " to "
            << fixed(found->interval.high, 3)
            << ") of those without feedback.\nOsborn et al. (2016) have less than 0.5, which "
            << (found->value < halved_below ? "holds" : "does not hold") << " here.\n";
    const auto compared = against_rate(rows);
    if (compared.empty()) return;
    out << "\nAgainst rate, in the same presentations: difference in points, with its 95 % interval\n\n"
        << std::left << std::setw(16) << "condition" << std::setw(26) << "broken, of delicate"
        << "dropped, of all\n";
    for (const auto& [condition, broken, dropped] : compared)
        out << std::left << std::setw(16) << condition << std::setw(26) << points(broken) << points(dropped)
            << '\n';
}

}  // namespace

Summary summary_of(const std::vector<TrialRows>& rows) {
    Summary summary;
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        Summary entry{{"condition", row.condition}, {"presentations", tally.presentations()}};
        add_percent(entry, "broken", tally.broken());
        add_percent(entry, "dropped", tally.dropped());
        const auto& found = row.paper;
        entry["paper_pct"] = found ? Summary(percent(found->broken)) : Summary();
        entry["paper_low_pct"] = found ? Summary(100 * interval_95(found->broken).low) : Summary();
        entry["paper_high_pct"] = found ? Summary(100 * interval_95(found->broken).high) : Summary();
        entry["fitted_or_predicted"] = source_of(row);
        entry["told_p50_ms"] = in_ms(tally.told_s(0.5));
        entry["answer_p10_ms"] = in_ms(tally.answer_s(0.1));
        entry["answer_p50_ms"] = in_ms(tally.answer_s(0.5));
        entry["answer_p90_ms"] = in_ms(tally.answer_s(0.9));
        entry["mean_peak_n"] = known(tally.mean_peak_n());
        entry["safe_state_pct"] = known(percent(tally.safe_state()));
        entry["slippery"] = summary_of_slips(row.tallies);
        summary["conditions"].push_back(std::move(entry));
    }
    if (const auto found = rate_less_force(rows)) {
        summary["rate_less_force"] = summary_of(found->ours, 100, "_points");
        summary["rate_less_force"]["paper"] = summary_of(found->the_papers, 100, "_points");
    }
    if (const auto found = failed_over_none(rows)) {
        summary["failed_over_none"] = summary_of(*found, 1, "");
        summary["failed_over_none"]["condition"] = std::string(halved_condition);
        summary["failed_over_none"]["published_below"] = halved_below;
    }
    for (const auto& [condition, broken, dropped] : against_rate(rows)) {
        Summary entry{{"condition", condition}};
        entry["broken"] = summary_of(broken, 100, "_points");
        entry["dropped"] = summary_of(dropped, 100, "_points");
        summary["against_rate"].push_back(std::move(entry));
    }
    return summary;
}

void print_trial(const std::vector<TrialRows>& rows, std::ostream& out) {
    print_conditions(rows, out);
    print_predictions(rows, out);
    print_slips(rows, out);
}

Summary summary_of(const std::vector<TrialCell>& cells) {
    Summary summary{Summary::List{}};
    for (const TrialCell& cell : cells) {
        const auto& [delicate, slippery] = cell.tallies;
        Summary entry{{"changed", cell.changed},
                      {"value", cell.value ? Summary(*cell.value) : Summary()},
                      {"condition", cell.condition},
                      {"presentations", delicate.presentations()}};
        add_percent(entry, "broken", delicate.broken());
        entry["dropped_pct"] = known(percent(delicate.dropped()));
        entry["slippery_dropped_pct"] = known(percent(slippery.dropped()));
        entry["safe_state_pct"] = known(percent(delicate.safe_state()));
        summary.push_back(std::move(entry));
    }
    return summary;
}

void print_cells(const std::vector<TrialCell>& cells, std::ostream& out) {
    std::size_t width = 12;
    for (const TrialCell& cell : cells) width = std::max(width, cell.changed.size() + 2);
    out << std::left << std::setw(static_cast<int>(width)) << "changed" << std::right << std::setw(9)
        << "value"
        << "  " << std::left << std::setw(15) << "condition" << std::right << std::setw(14) << "presentations"
        << std::setw(10) << "broken %" << std::setw(15) << "95 %" << std::setw(11) << "dropped %"
        << std::setw(20) << "heavy, dropped %" << std::setw(14) << "safe state %" << '\n';
    for (const TrialCell& cell : cells) {
        const auto& [delicate, slippery] = cell.tallies;
        std::ostringstream value;
        if (cell.value) value << std::setprecision(4) << *cell.value;
        out << std::left << std::setw(static_cast<int>(width)) << cell.changed << std::right << std::setw(9)
            << value.str() << "  " << std::left << std::setw(15) << cell.condition << std::right
            << std::setw(14) << delicate.presentations() << std::setw(10)
            << fixed(percent(delicate.broken()), 2) << std::setw(15) << range_of(delicate.broken())
            << std::setw(11) << fixed(percent(delicate.dropped()), 2) << std::setw(20)
            << fixed(percent(slippery.dropped()), 2) << std::setw(14)
            << fixed(percent(delicate.safe_state()), 2) << '\n';
    }
}

Summary summary_of(const TrialCalibration& calibration) {
    Summary summary;
    for (const CalibratedNumber* number : {&calibration.stiffness, &calibration.aim}) {
        const TrialNumber& known = *find_trial_number(number->path);
        const Bounds interval = interval_95(number->found.counted);
        summary.push_back({{"path", std::string(number->path)},
                           {"value", number->found.parameter},
                           {"sigma", number->found.sigma},
                           {"plausible_low", known.low},
                           {"plausible_high", known.high},
                           {"is_reached", number->found.is_reached},
                           {"condition", std::string(number->condition)},
                           {"broken_pct", percent(number->found.counted)},
                           {"broken_low_pct", 100 * interval.low},
                           {"broken_high_pct", 100 * interval.high},
                           {"paper_pct", percent(published(number->condition)->broken)}});
    }
    return summary;
}

void print_calibration(const TrialCalibration& calibration, std::ostream& out) {
    for (const CalibratedNumber* number : {&calibration.stiffness, &calibration.aim}) {
        const auto& [parameter, counted, sigma, is_reached] = number->found;
        const TrialNumber& known = *find_trial_number(number->path);
        out << std::setprecision(4) << number->path << ": " << parameter << " ± " << sigma << ", within "
            << known.low << " to " << known.high << ": " << std::setprecision(3) << percent(counted)
            << " % of " << counted.of << " delicate objects break with the condition " << number->condition
            << ", in the paper " << percent(published(number->condition)->broken) << " %\n";
        if (!is_reached) out << "  That is the end of its range: the paper's figure is not reached.\n";
    }
}

Summary summary_of(const Scene& scene, std::span<const TrialNumber* const> numbers) {
    Summary summary;
    for (const TrialNumber* number : numbers)
        summary.push_back({{"path", std::string(number->path)},
                           {"value", value_in(scene, *number)},
                           {"low", number->low},
                           {"high", number->high},
                           {"source", std::string(number->source)}});
    return summary;
}

}  // namespace afferent
