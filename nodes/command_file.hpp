// An output that writes each command of a hand to a table.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "afferent/engine/controller.hpp"
#include "afferent/io/files/table_writer.hpp"
#include "afferent/nodes/output_thread.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// One row for each step: time_s, force_n, sigma_n, gain, command, doubt. A full disk stops no hand: the first
// error waits for close(). Where a named pipe is not to be waited for, its rows are lost while nobody reads
// it.
class CommandFile {
  public:
    static constexpr OutputThread thread = OutputThread::writer;
    using Described = scene::CommandFile;

    // `unreachable` where the file cannot be written.
    static Result<CommandFile> open(const Scene& scene, const Described& given, FullPipe full_pipe);

    void observe(const TimeSpan&, std::span<const Event>) noexcept {}
    void take(const ControllerStep& step);
    Result<void> close();
    OutputLosses lost() const noexcept { return {.steps = table_.lost_rows(), .events = 0}; }
    std::optional<std::string> notice() const;

  private:
    CommandFile(const std::filesystem::path& file, FullPipe full_pipe);

    TableWriter table_;
};

}  // namespace afferent
