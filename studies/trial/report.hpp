// What a trial found: for people, and for programs.
#pragma once

#include <ostream>
#include <span>
#include <vector>

#include "afferent/runtime/summary.hpp"
#include "afferent/studies/trial/calibration.hpp"
#include "afferent/studies/trial/questions.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {

// The tables of a trial (studies/trial/tables.hpp), and what is predicted.
Summary summary_of(const std::vector<TrialRows>& rows);
void print_trial(const std::vector<TrialRows>& rows, std::ostream& out);

Summary summary_of(const std::vector<TrialCell>& cells);
void print_cells(const std::vector<TrialCell>& cells, std::ostream& out);

// Both numbers, and where they come from.
Summary summary_of(const TrialCalibration& calibration);
void print_calibration(const TrialCalibration& calibration, std::ostream& out);

// The numbers of a scene whose plausible ranges a question goes through.
Summary summary_of(const Scene& scene, std::span<const TrialNumber* const> numbers);

}  // namespace afferent
