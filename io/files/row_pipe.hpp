// A named pipe for rows of text that does not wait for its reader.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace afferent {

// Rows that the pipe does not take wait, up to `most_waiting` bytes. Rows that do not fit there, or come
// while nobody reads the pipe, are lost and counted. A reader may come late or come back: it gets the head
// first, and then the rows from there on.
class RowPipe {
  public:
    static constexpr std::size_t most_waiting = std::size_t{1} << 20;

    // `pipe` exists. `head` is a row.
    RowPipe(std::filesystem::path pipe, std::string head);
    ~RowPipe();
    RowPipe(const RowPipe&) = delete;
    RowPipe& operator=(const RowPipe&) = delete;

    void put(std::string_view row);
    // Waits until the reader has taken the waiting rows. False: it has taken nothing for so long, and the
    // rest is lost.
    bool finish(std::chrono::milliseconds patience);

    bool has_reader() const noexcept { return file_ >= 0; }
    std::uint64_t lost_rows() const noexcept { return lost_rows_; }
    // The errno of a failure other than the lack of a reader.
    int error() const noexcept { return error_; }

  private:
    void open();
    // False: the pipe takes nothing more at the moment.
    bool write_some();
    void close();

    std::filesystem::path pipe_;
    std::string head_;
    int file_ = -1;
    int error_ = 0;
    std::string waiting_;
    std::size_t written_ = 0;     // of it
    std::size_t head_bytes_ = 0;  // which it begins with
    std::uint64_t lost_rows_ = 0;
};

}  // namespace afferent
