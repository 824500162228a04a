#include "afferent/apps/trial_report.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/studies/trial/published.hpp"

namespace afferent {
namespace {

void finish(TableWriter& table) {
    if (const auto error = table.close()) throw Failure(error->message());
}

void optional_cell(TableWriter& table, const std::optional<double>& value) {
    if (value && std::isfinite(*value))
        table.cell(*value);
    else
        table.no_value();
}

// With as many digits as counting so many presentations gives.
void percent_cell(TableWriter& table, double share) {
    if (std::isfinite(share))
        table.cell(100 * share, 3);
    else
        table.no_value();
}

void interval_cells(TableWriter& table, const Proportion& proportion) {
    const Bounds interval = interval_95(proportion);
    percent_cell(table, proportion.value());
    percent_cell(table, interval.low);
    percent_cell(table, interval.high);
}

const char* kind_of(const TrialRows& rows) {
    return rows.paper && rows.paper->is_fitted ? "fitted" : "predicted";
}

Summary known(double value) { return std::isfinite(value) ? Summary(value) : Summary(); }

Summary in_ms(const std::optional<double>& time_s) { return time_s ? Summary(1e3 * *time_s) : Summary(); }

void add_percent(Summary& summary, const std::string& name, const Proportion& proportion) {
    const Bounds interval = interval_95(proportion);
    summary[name + "_pct"] = known(percent(proportion));
    summary[name + "_low_pct"] = 100 * interval.low;
    summary[name + "_high_pct"] = 100 * interval.high;
}

Summary summary_of_slips(const Tally& tally) {
    Summary summary{{"presentations", tally.presentations()}};
    add_percent(summary, "dropped", tally.dropped());
    summary["slips"] = tally.slips();
    summary["answered"] = tally.reactions();
    summary["reaction_p10_ms"] = in_ms(tally.reaction_s(0.1));
    summary["reaction_p50_ms"] = in_ms(tally.reaction_s(0.5));
    summary["reaction_p90_ms"] = in_ms(tally.reaction_s(0.9));
    return summary;
}

const TrialRows* rows_of(const std::vector<TrialRows>& rows, std::string_view condition) {
    const auto found = std::ranges::find(rows, condition, &TrialRows::condition);
    return found == rows.end() ? nullptr : &*found;
}

bool is_broken(const Presentation& one) { return !one.slippery && one.outcome == Outcome::broken; }
bool is_dropped(const Presentation& one) { return one.outcome == Outcome::dropped; }
bool has_failed(const Presentation& one) { return !one.slippery && one.outcome != Outcome::held; }

std::vector<Presentation> delicate_of(const TrialRows& rows) {
    std::vector<Presentation> delicate;
    for (const Presentation& one : rows.presentations)
        if (!one.slippery) delicate.push_back(one);
    return delicate;
}

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
    const auto delicate = delicate_of(*rate);
    for (const TrialRows& other : rows) {
        if (other.condition == "none" || other.condition == "rate") continue;
        const auto broken = difference(paired(delicate, delicate_of(other), is_broken));
        const auto dropped = difference(paired(rate->presentations, other.presentations, is_dropped));
        if (broken && dropped) compared.push_back({other.condition, *broken, *dropped});
    }
    return compared;
}

Summary summary_of(const Estimated& estimated, double scale, const std::string& unit) {
    return {{"value" + unit, scale * estimated.value},
            {"low" + unit, scale * estimated.interval.low},
            {"high" + unit, scale * estimated.interval.high}};
}

std::string fixed(double value, int decimals) {
    if (!std::isfinite(value)) return "-";
    std::ostringstream text;
    text << std::fixed << std::setprecision(decimals) << value;
    return text.str();
}

std::string range_of(const Proportion& proportion) {
    const Bounds interval = interval_95(proportion);
    return fixed(100 * interval.low, 1) + " to " + fixed(100 * interval.high, 1);
}

// "+1.2 (0.8 to 1.6)", in points.
std::string points(const Estimated& estimated) {
    const auto [low, high] = estimated.interval;
    return (estimated.value > 0 ? "+" : "") + fixed(100 * estimated.value, 2) + " (" + fixed(100 * low, 2) +
           " to " + fixed(100 * high, 2) + ")";
}

std::string milliseconds(const std::optional<double>& time_s) {
    return time_s ? fixed(1e3 * *time_s, 0) : "-";
}

void print_conditions(const std::vector<TrialRows>& rows, std::ostream& out) {
    out << "Delicate objects\n\n"
        << std::left << std::setw(16) << "condition" << std::right << std::setw(14) << "presentations"
        << std::setw(10) << "broken %" << std::setw(15) << "95 %" << std::setw(11) << "dropped %"
        << std::setw(13) << "the paper %" << std::setw(15) << "95 %"
        << "\n";
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        out << std::left << std::setw(16) << row.condition << std::right << std::setw(14)
            << tally.presentations() << std::setw(10) << fixed(percent(tally.broken()), 2) << std::setw(15)
            << range_of(tally.broken()) << std::setw(11) << fixed(percent(tally.dropped()), 2);
        if (const auto& found = row.paper)
            out << std::setw(13) << fixed(percent(found->broken), 1) << std::setw(15)
                << range_of(found->broken) << "  " << kind_of(row);
        out << '\n';
    }
}

void print_slips(const std::vector<TrialRows>& rows, std::ostream& out) {
    const bool any = std::ranges::any_of(
        rows, [](const TrialRows& row) { return row.tallies.slippery.presentations() > 0; });
    if (!any) return;
    out << "\nThe heavy object that slips; from the onset of a slip until the gain lets the hand close "
           "further "
           "(published: 35 to 85 ms)\n\n"
        << std::left << std::setw(16) << "condition" << std::right << std::setw(14) << "presentations"
        << std::setw(11) << "dropped %" << std::setw(15) << "95 %" << std::setw(9) << "slips" << std::setw(11)
        << "answered" << std::setw(12) << "median ms" << std::setw(8) << "10 %" << std::setw(8) << "90 %"
        << '\n';
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.slippery;
        out << std::left << std::setw(16) << row.condition << std::right << std::setw(14)
            << tally.presentations() << std::setw(11) << fixed(percent(tally.dropped()), 2) << std::setw(15)
            << range_of(tally.dropped()) << std::setw(9) << tally.slips() << std::setw(11)
            << tally.reactions() << std::setw(12) << milliseconds(tally.reaction_s(0.5)) << std::setw(8)
            << milliseconds(tally.reaction_s(0.1)) << std::setw(8) << milliseconds(tally.reaction_s(0.9))
            << '\n';
    }
}

void print_predictions(const std::vector<TrialRows>& rows, std::ostream& out) {
    if (const TrialRows* rate = rows_of(rows, "rate"); rate && rate->paper) {
        const Proportion ours = rate->tallies.delicate.broken();
        const Proportion theirs = rate->paper->broken;
        if (ours.of > 0)
            out << "\nPredicted, and fitted to nothing: with spike rate " << fixed(percent(ours), 2)
                << " % break (" << range_of(ours) << ").\nThe paper has " << fixed(percent(theirs), 1)
                << " % (" << range_of(theirs) << " for 200 presentations), "
                << (interval_95(theirs).holds(ours.value()) ? "which agrees" : "which does not agree")
                << ".\n";
    }
    if (const auto found = failed_over_none(rows))
        out << "\nPredicted, and fitted to nothing: with " << halved_condition << ", broken and dropped are "
            << fixed(found->value, 3) << " (" << fixed(found->interval.low, 3) << " to "
            << fixed(found->interval.high, 3)
            << ") of those without feedback.\nOsborn et al. (2016) have less than 0.5, which "
            << (found->value < halved_below ? "agrees" : "does not agree") << ".\n";
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

double percent(const Proportion& proportion) { return 100 * proportion.value(); }

void write_presentations(const std::vector<TrialRows>& rows, const std::filesystem::path& file) {
    TableWriter table(file,
                      {"condition", "number", "object", "outcome", "breaking_force_n", "stiffness_n_per_mm",
                       "weight_n", "aimed_force_n", "peak_force_n", "held_force_n", "contact_s", "broken_s",
                       "dropped_s", "slip_onset_s", "slip_reaction_s", "safe_state"});
    for (const TrialRows& row : rows)
        for (const Presentation& one : row.presentations) {
            table.text(row.condition);
            table.cell(std::uint64_t{one.number});
            table.text(one.slippery ? "slippery" : "delicate");
            table.text(name(one.outcome));
            optional_cell(table, one.breaking_force_n);
            for (const double value : {one.stiffness_n_per_mm, one.weight_n, one.aimed_force_n,
                                       one.peak_force_n, one.held_force_n})
                table.cell(value);
            for (const auto& time_s :
                 {one.contact_s, one.broken_s, one.dropped_s, one.slip_onset_s, one.slip_reaction_s})
                optional_cell(table, time_s);
            table.cell(std::uint64_t{one.safe_state});
            table.end_row();
        }
    finish(table);
}

void write_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& file) {
    TableWriter table(file, {"condition", "presentations", "broken_pct", "broken_low_pct", "broken_high_pct",
                             "dropped_pct", "paper_pct", "fitted_or_predicted"});
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        table.text(row.condition);
        table.cell(tally.presentations());
        interval_cells(table, tally.broken());
        percent_cell(table, tally.dropped().value());
        const auto& found = row.paper;
        found ? table.cell(percent(found->broken), 1) : table.no_value();
        table.text(kind_of(row));
        table.end_row();
    }
    finish(table);
}

void write_slips(const std::vector<TrialRows>& rows, const std::filesystem::path& file) {
    TableWriter table(
        file, {"condition", "presentations", "dropped_pct", "dropped_low_pct", "dropped_high_pct", "slips",
               "answered", "reaction_p10_s", "reaction_p50_s", "reaction_p90_s"});
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.slippery;
        table.text(row.condition);
        table.cell(tally.presentations());
        interval_cells(table, tally.dropped());
        table.cell(tally.slips());
        table.cell(tally.reactions());
        for (const double part : {0.1, 0.5, 0.9}) optional_cell(table, tally.reaction_s(part));
        table.end_row();
    }
    finish(table);
}

Summary summary_of(const std::vector<TrialRows>& rows) {
    Summary summary;
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        Summary told{{"condition", row.condition}, {"presentations", tally.presentations()}};
        add_percent(told, "broken", tally.broken());
        add_percent(told, "dropped", tally.dropped());
        const auto& found = row.paper;
        told["paper_pct"] = found ? Summary(percent(found->broken)) : Summary();
        told["paper_low_pct"] = found ? Summary(100 * interval_95(found->broken).low) : Summary();
        told["paper_high_pct"] = found ? Summary(100 * interval_95(found->broken).high) : Summary();
        told["fitted_or_predicted"] = kind_of(row);
        told["mean_peak_n"] = known(tally.mean_peak_n());
        told["safe_state_pct"] = known(percent(tally.safe_state()));
        told["slippery"] = summary_of_slips(row.tallies.slippery);
        summary["conditions"].push_back(std::move(told));
    }
    if (const auto found = failed_over_none(rows)) {
        summary["failed_over_none"] = summary_of(*found, 1, "");
        summary["failed_over_none"]["condition"] = std::string(halved_condition);
        summary["failed_over_none"]["published_below"] = halved_below;
    }
    for (const auto& [condition, broken, dropped] : against_rate(rows)) {
        Summary told{{"condition", condition}};
        told["broken"] = summary_of(broken, 100, "_points");
        told["dropped"] = summary_of(dropped, 100, "_points");
        summary["against_rate"].push_back(std::move(told));
    }
    return summary;
}

void print_trial(const std::vector<TrialRows>& rows, std::ostream& out) {
    print_conditions(rows, out);
    print_predictions(rows, out);
    print_slips(rows, out);
}

void write_cells(const std::vector<TrialCell>& cells, const std::filesystem::path& file) {
    TableWriter table(file, {"changed", "value", "condition", "presentations", "broken_pct", "broken_low_pct",
                             "broken_high_pct", "dropped_pct", "slippery_dropped_pct", "safe_state_pct"});
    for (const TrialCell& cell : cells) {
        const auto& [delicate, slippery] = cell.tallies;
        table.text(cell.changed);
        optional_cell(table, cell.value);
        table.text(cell.condition);
        table.cell(delicate.presentations());
        interval_cells(table, delicate.broken());
        for (const Proportion& share : {delicate.dropped(), slippery.dropped(), delicate.safe_state()})
            percent_cell(table, share.value());
        table.end_row();
    }
    finish(table);
}

Summary summary_of(const std::vector<TrialCell>& cells) {
    Summary summary{Summary::List{}};
    for (const TrialCell& cell : cells) {
        const auto& [delicate, slippery] = cell.tallies;
        Summary told{{"changed", cell.changed},
                     {"value", cell.value ? Summary(*cell.value) : Summary()},
                     {"condition", cell.condition},
                     {"presentations", delicate.presentations()}};
        add_percent(told, "broken", delicate.broken());
        told["dropped_pct"] = known(percent(delicate.dropped()));
        told["slippery_dropped_pct"] = known(percent(slippery.dropped()));
        told["safe_state_pct"] = known(percent(delicate.safe_state()));
        summary.push_back(std::move(told));
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

}  // namespace afferent
