// What a trial found: as tables in files, for people, and for programs.
#pragma once

#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "afferent/apps/summary.hpp"
#include "afferent/studies/trial/presentation.hpp"
#include "afferent/studies/trial/published.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {

// The presentations of one condition.
struct TrialRows {
    std::string condition;
    std::vector<Presentation> presentations;
    Tallies tallies;  // of them
    // What the paper has, if anything. None where EMG was recorded: that is another user than the calibrated.
    std::optional<Published> paper;
};

// trial.csv: a row for each presentation. Throws Failure.
void write_presentations(const std::vector<TrialRows>& rows, const std::filesystem::path& file);
// trial_summary.csv: a row for each condition, of the objects that break. Throws Failure.
void write_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& file);
// trial_slip.csv: the same of the object that slips.
void write_slips(const std::vector<TrialRows>& rows, const std::filesystem::path& file);

// The tables above, and what is predicted.
Summary summary_of(const std::vector<TrialRows>& rows);
void print_trial(const std::vector<TrialRows>& rows, std::ostream& out);

// One condition of a scene in which something has been changed.
struct TrialCell {
    std::string changed;  // a path in the scene, or an ablation; empty: nothing
    std::optional<double> value;
    std::string condition;
    Tallies tallies;
};

// Columns as in trial_summary.csv, behind what has been changed. Throws Failure.
void write_cells(const std::vector<TrialCell>& cells, const std::filesystem::path& file);
Summary summary_of(const std::vector<TrialCell>& cells);
void print_cells(const std::vector<TrialCell>& cells, std::ostream& out);

double percent(const Proportion& proportion);

}  // namespace afferent
