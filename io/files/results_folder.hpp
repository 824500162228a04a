// A folder of results: those of one run come into it together or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "afferent/io/wire/result.hpp"

namespace afferent {

// Results are written to a folder of this process inside the one that they are for, and put in place when all
// of them are complete. A run that fails leaves what was there before. One that is killed leaves that, and
// its unfinished folder beside it.
//
//     AFFERENT_TRY(results, ResultsFolder::create("out", {"events.csv", "summary.json"}));
//     TableWriter events(results.unfinished() / "events.csv", ...);
//     ...
//     AFFERENT_TRY(results.put_in_place());
class ResultsFolder {
  public:
    // Makes the folder. `names`: what may be in it of such a run; the last says that the others are complete,
    // so it goes first and comes last: whenever it is there, everything is of the run that it tells of. What
    // is there already and is no file, a pipe or a device, is written to as it is.
    static Result<ResultsFolder> create(std::filesystem::path folder, std::vector<std::string> names);

    ResultsFolder(ResultsFolder&& other) noexcept;
    ResultsFolder& operator=(ResultsFolder&&) = delete;
    // Removes what has not been put in place.
    ~ResultsFolder();

    // Where to write.
    const std::filesystem::path& unfinished() const noexcept { return unfinished_; }
    // Once all is written and closed: replaces what a run before has left, and removes what this one does not
    // have.
    Result<void> put_in_place();
    // Afterwards: puts another file in place, where it has been written since.
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
