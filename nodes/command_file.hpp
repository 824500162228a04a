// An output that writes each command of a hand to a table.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "afferent/engine/controller.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// One row for each step: time_s, force_n, sigma_n, gain, command, doubt.
class CommandFile {
  public:
    // `unreachable` where the file cannot be written.
    static Result<CommandFile> open(const std::filesystem::path& file, FullPipe full_pipe);

    // The first error stands until close(): a full disk must not stop a hand.
    void take(const ControllerStep& step);
    Result<void> close();
    // The file, if it is a named pipe that nobody reads.
    std::optional<std::filesystem::path> unread_pipe() const {
        return table_.is_unread() ? std::optional(table_.file()) : std::nullopt;
    }
    // Steps that the pipe did not take; final after close().
    std::uint64_t lost_steps() const noexcept { return table_.lost_rows(); }

  private:
    CommandFile(const std::filesystem::path& file, FullPipe full_pipe);

    TableWriter table_;
};

}  // namespace afferent
