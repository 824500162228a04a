// A folder of results: the files of one run appear in it together or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "afferent/runtime/result.hpp"

namespace afferent {

// Results are written to a temporary folder inside the one that they are for, and moved to it when all of
// them are complete. A run that fails leaves what was there before. One that is killed does too, and leaves
// its unfinished folder as well.
//
//     AFFERENT_TRY(results, ResultsFolder::create("out", {"events.csv", "summary.json"}));
//     TableWriter events(results.unfinished() / "events.csv", ...);
//     ...
//     AFFERENT_TRY(results.put_in_place());
class ResultsFolder {
  public:
    // Makes the folder. `names` are the files that such a run may leave in it. The last of them says that the
    // others are complete: it is removed first and put in place last, so that whenever it is there, every
    // file belongs to the run that it describes. An existing pipe or device of such a name is written to
    // directly.
    static Result<ResultsFolder> create(std::filesystem::path folder, std::vector<std::string> names);

    ResultsFolder(ResultsFolder&& other) noexcept;
    ResultsFolder& operator=(ResultsFolder&&) = delete;
    // Removes what has not been put in place.
    ~ResultsFolder();

    // The folder to write to.
    const std::filesystem::path& unfinished() const noexcept { return unfinished_; }
    // Once everything is written and closed: replaces the files of an earlier run, and removes those that
    // this run does not have.
    Result<void> put_in_place();
    // After put_in_place(): puts another file in place that has been written since.
    Result<void> add(const std::string& name);
    // What has not been put in place stays where it was written.
    void keep_unfinished() noexcept { keeps_unfinished_ = true; }

  private:
    ResultsFolder(std::filesystem::path folder, std::vector<std::string> names);
    bool is_written_directly(const std::string& name) const;
    Error cannot_place(const std::string& name, const std::error_code& failure) const;

    std::filesystem::path folder_;
    std::filesystem::path unfinished_;
    std::vector<std::string> names_;
    bool keeps_unfinished_ = false;
};

}  // namespace afferent
