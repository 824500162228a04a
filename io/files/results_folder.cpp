#include "afferent/io/files/results_folder.hpp"

#include <unistd.h>

#include <utility>

namespace afferent {

namespace fs = std::filesystem;

ResultsFolder::ResultsFolder(fs::path folder, std::vector<std::string> names)
    : folder_(std::move(folder)),
      unfinished_(folder_ / ("unfinished-" + std::to_string(::getpid()))),
      names_(std::move(names)) {}

ResultsFolder::ResultsFolder(ResultsFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      unfinished_(std::exchange(other.unfinished_, {})),
      names_(std::move(other.names_)),
      keeps_unfinished_(other.keeps_unfinished_) {}

ResultsFolder::~ResultsFolder() {
    std::error_code ignored;
    if (!unfinished_.empty() && !keeps_unfinished_) fs::remove_all(unfinished_, ignored);
}

Result<ResultsFolder> ResultsFolder::create(fs::path folder, std::vector<std::string> names) {
    std::error_code failure;
    const fs::path absolute = fs::absolute(folder, failure);
    ResultsFolder made(std::move(folder), std::move(names));
    if (!failure) fs::create_directories(made.unfinished_, failure);
    if (failure)
        return Error{Error::Kind::not_allowed,
                     made.folder_.string() + ": results cannot be written there: " + failure.message()};
    for (const std::string& name : made.names_) {
        const fs::file_status status = fs::status(absolute / name, failure);
        if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status)) continue;
        fs::create_symlink(absolute / name, made.unfinished_ / name, failure);
    }
    return made;
}

bool ResultsFolder::is_written_directly(const std::string& name) const {
    std::error_code ignored;
    return fs::is_symlink(fs::symlink_status(unfinished_ / name, ignored));
}

Error ResultsFolder::cannot_place(const std::string& name, const std::error_code& failure) const {
    return {Error::Kind::not_allowed,
            (folder_ / name).string() + ": cannot be put in place: " + failure.message()};
}

Result<void> ResultsFolder::put_in_place() {
    std::error_code failure;
    const std::string& complete = names_.back();
    if (!is_written_directly(complete)) {
        fs::remove(folder_ / complete, failure);
        if (failure) return cannot_place(complete, failure);
    }
    for (const std::string& name : names_) {
        if (is_written_directly(name)) continue;
        if (fs::exists(unfinished_ / name, failure))
            fs::rename(unfinished_ / name, folder_ / name, failure);
        else if (!failure)
            fs::remove(folder_ / name, failure);
        if (failure) return cannot_place(name, failure);
    }
    return success();
}

Result<void> ResultsFolder::add(const std::string& name) {
    std::error_code failure;
    if (!is_written_directly(name) && fs::exists(unfinished_ / name, failure))
        fs::rename(unfinished_ / name, folder_ / name, failure);
    if (failure) return cannot_place(name, failure);
    return success();
}

}  // namespace afferent
