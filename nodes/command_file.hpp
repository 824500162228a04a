// An output that writes each command of a hand to a table.
#pragma once

#include <filesystem>

#include "afferent/io/files/table_writer.hpp"
#include "afferent/io/wire/result.hpp"
#include "afferent/scene/controller.hpp"

namespace afferent {

// One row for each step: time_s, force_n, sigma_n, gain, command.
class CommandFile {
  public:
    // `unreachable` where the file cannot be written.
    static Result<CommandFile> open(const std::filesystem::path& file, FullPipe full_pipe);

    // The first error stands until close(): a full disk must not stop a hand.
    void take(const ControllerStep& step);
    Result<void> close();
    const TableWriter& table() const noexcept { return table_; }

  private:
    CommandFile(const std::filesystem::path& file, FullPipe full_pipe);

    TableWriter table_;
};

}  // namespace afferent
