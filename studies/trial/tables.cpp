#include "afferent/studies/trial/tables.hpp"

#include <cmath>

#include "afferent/io/files/table_writer.hpp"

namespace afferent {
namespace {

Result<void> finish(TableWriter& table) {
    if (const auto error = table.close()) return Error{Error::Kind::unreachable, error->message()};
    return success();
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

}  // namespace

const char* source_of(const TrialRows& rows) {
    return rows.paper && rows.paper->is_fitted ? "fitted" : "predicted";
}

Result<void> write_presentations(const std::vector<TrialRows>& rows, const std::filesystem::path& file) {
    TableWriter table(
        file, {"condition",          "number",          "object",        "outcome",      "breaking_force_n",
               "stiffness_n_per_mm", "weight_n",        "aimed_force_n", "peak_force_n", "held_force_n",
               "contact_s",          "told_s",          "answer_s",      "broken_s",     "dropped_s",
               "slip_onset_s",       "slip_reaction_s", "slipped_mm",    "false_pulses", "safe_state"});
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
            for (const auto& time_s : {one.contact_s, one.told_s, one.answer_s, one.broken_s, one.dropped_s,
                                       one.slip_onset_s, one.slip_reaction_s})
                optional_cell(table, time_s);
            table.cell(one.slipped_mm);
            table.cell(std::uint64_t{one.false_pulses});
            table.cell(std::uint64_t{one.safe_state});
            table.end_row();
        }
    return finish(table);
}

Result<void> write_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& file) {
    TableWriter table(file, {"condition", "presentations", "broken_pct", "broken_low_pct", "broken_high_pct",
                             "dropped_pct", "paper_pct", "fitted_or_predicted", "told_p50_s", "answer_p10_s",
                             "answer_p50_s", "answer_p90_s"});
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        table.text(row.condition);
        table.cell(tally.presentations());
        interval_cells(table, tally.broken());
        percent_cell(table, tally.dropped().value());
        const auto& found = row.paper;
        found ? table.cell(100 * found->broken.value(), 1) : table.no_value();
        table.text(source_of(row));
        optional_cell(table, tally.told_s(0.5));
        for (const double part : {0.1, 0.5, 0.9}) optional_cell(table, tally.answer_s(part));
        table.end_row();
    }
    return finish(table);
}

Result<void> write_slips(const std::vector<TrialRows>& rows, const std::filesystem::path& file) {
    TableWriter table(file, {"condition", "presentations", "dropped_pct", "dropped_low_pct",
                             "dropped_high_pct", "slips", "answered", "reaction_p10_s", "reaction_p50_s",
                             "reaction_p90_s", "stopped_pct", "slipped_p50_mm", "false_pulses_pct"});
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.slippery;
        table.text(row.condition);
        table.cell(tally.presentations());
        interval_cells(table, tally.dropped());
        table.cell(tally.slips());
        table.cell(tally.reactions());
        for (const double part : {0.1, 0.5, 0.9}) optional_cell(table, tally.reaction_s(part));
        percent_cell(table, tally.stopped().value());
        optional_cell(table, tally.slipped_mm(0.5));
        percent_cell(table, row.tallies.false_pulses().value());
        table.end_row();
    }
    return finish(table);
}

Result<void> write_cells(const std::vector<TrialCell>& cells, const std::filesystem::path& file) {
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
    return finish(table);
}

}  // namespace afferent
