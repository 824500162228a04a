// The results of a command: files that appear in a folder together, if it is to write any, and their
// pictures.
#pragma once

#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/io/pictures/gnuplot.hpp"

namespace afferent {

class Results {
  public:
    // `names` as for ResultsFolder. No folder: nothing is written. Throws Failure.
    Results(const std::string& folder, std::vector<std::string> names) {
        if (!folder.empty()) folder_.emplace(value_or_fail(ResultsFolder::create(folder, std::move(names))));
    }
    bool wanted() const noexcept { return folder_.has_value(); }
    std::filesystem::path file(const char* name) const { return folder_->unfinished() / name; }
    // Writes the summary and puts everything in place.
    void put_in_place(const Summary& summary, const char* name) {
        write(summary, file(name));
        value_or_fail(folder_->put_in_place());
    }

  private:
    std::optional<ResultsFolder> folder_;
};

// Says on standard error why a picture could not be drawn.
inline void tell_if_undrawn(const Drawing& drawing) {
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "no picture: gnuplot is not installed\n";
    if (drawing.outcome == Drawn::failed)
        std::cerr << "no picture: gnuplot failed: " << drawing.message << '\n';
}

}  // namespace afferent
