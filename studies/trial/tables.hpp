// The answers of a trial as tables in files. `unreachable`: the file cannot be written.
#pragma once

#include <filesystem>
#include <vector>

#include "afferent/runtime/result.hpp"
#include "afferent/studies/trial/questions.hpp"

namespace afferent {

// trial.csv: a row for each presentation.
Result<void> write_presentations(const std::vector<TrialRows>& rows, const std::filesystem::path& file);
// trial_summary.csv: a row for each condition, of the objects that break.
Result<void> write_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& file);
// trial_slip.csv: the same of the object that slips.
Result<void> write_slips(const std::vector<TrialRows>& rows, const std::filesystem::path& file);
// Columns as in trial_summary.csv, behind what has been changed.
Result<void> write_cells(const std::vector<TrialCell>& cells, const std::filesystem::path& file);

// "fitted" where the trial was calibrated on the paper's figure of that condition, else "predicted".
const char* source_of(const TrialRows& rows);

}  // namespace afferent
