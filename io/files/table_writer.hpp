// Writes a CSV table, cell by cell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "afferent/io/files/row_pipe.hpp"
#include "afferent/io/files/table_error.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// What happens to rows for a named pipe that is full or that nobody reads: the writer waits, or the rows are
// lost and counted (RowPipe).
enum class FullPipe { wait, lose_rows };

// The rows go to a file with `.part` after its name, which is renamed when it is closed: a run that is killed
// leaves what it had recorded, and nothing that could be taken for the complete table. A pipe or a device is
// written directly.
//
//     TableWriter writer("out/events.csv", {"time_s", "address"});
//     writer.cell(event.time);
//     writer.cell(event.address);
//     writer.end_row();
//     if (const auto error = writer.close()) ...
class TableWriter {
  public:
    TableWriter(std::filesystem::path file, std::span<const std::string_view> columns,
                FullPipe full_pipe = FullPipe::wait);
    TableWriter(std::filesystem::path file, std::initializer_list<std::string_view> columns,
                FullPipe full_pipe = FullPipe::wait)
        : TableWriter(std::move(file), std::span(columns.begin(), columns.size()), full_pipe) {}

    // Exact: seconds with nine decimals.
    void cell(TimePoint time);
    void cell(std::uint64_t count);
    // The shortest digits that read back as the same number. It must be finite.
    void cell(double value);
    // With this number of decimals, for people to read.
    void cell(double value, int decimals);
    // Any text, in quotes where it needs them.
    void text(std::string_view text);
    // An empty cell: the value is not known.
    void no_value();
    void end_row();

    // The first error, if there was one: the folder is not writable, or the disk is full. Everything written
    // after it is lost.
    const std::optional<TableError>& error() const noexcept { return error_; }
    // Whether it is a named pipe for which rows do not wait.
    bool is_pipe() const noexcept { return is_pipe_; }
    // Whether it is such a pipe and nobody reads it.
    bool is_unread() const noexcept { return pipe_ && !pipe_->has_reader(); }
    // Rows lost with FullPipe::lose_rows; final after close().
    std::uint64_t lost_rows() const noexcept { return pipe_ ? pipe_->lost_rows() : 0; }
    const std::filesystem::path& file() const noexcept { return file_; }
    // Gives the file its name. A pipe gets a second to take the rest.
    [[nodiscard]] std::optional<TableError> close();

  private:
    void put(std::string_view bytes);
    void put_cell(std::string_view text);
    void fail(std::string_view what);

    std::filesystem::path file_;
    std::filesystem::path part_;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> out_{nullptr, std::fclose};
    std::unique_ptr<RowPipe> pipe_;  // or
    std::string row_;                // for it
    bool is_pipe_;
    std::size_t columns_;
    std::size_t cells_ = 0;  // of the current row
    std::optional<TableError> error_;
};

}  // namespace afferent
