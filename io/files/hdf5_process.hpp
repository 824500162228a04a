// Files of events and of scans in HDF5, read and written by a separate program, afferent-hdf5. The library
// for HDF5 was written for trusted files: others make it run forever or crash. In a process of its own it
// does no harm, and this program need not load it.
#pragma once

#include <chrono>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "afferent/io/files/event_set.hpp"
#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/scan_set.hpp"
#include "afferent/io/files/table_format.hpp"

namespace afferent {

struct Hdf5Limits {
    std::chrono::seconds processor_time;
    std::uint64_t memory_mb;
};

// A program of which the output is read, or an end to it.
class ReadingProcess {
  public:
    ReadingProcess(int process, InputFile output) noexcept : process_(process), output_(std::move(output)) {}
    ReadingProcess(ReadingProcess&& other) noexcept;
    ReadingProcess& operator=(ReadingProcess&&) = delete;
    // Ends the program.
    ~ReadingProcess();

    std::size_t read(std::span<std::byte> bytes);
    // Its status, once its output has ended.
    int wait();

  private:
    int process_ = 0;
    InputFile output_;
};

// The text of a table's columns (column_text.hpp), as the program writes it.
class ColumnTextInput {
  public:
    ColumnTextInput(std::filesystem::path file, ReadingProcess process, Hdf5Limits limits, std::uint64_t rows)
        : file_(std::move(file)), process_(std::move(process)), limits_(limits), rows_(rows) {}

    // Fills the buffer, or what of it there is; 0 at the end.
    Result<std::size_t> read(std::span<char> buffer);
    double fraction() const noexcept { return static_cast<double>(lines_) / static_cast<double>(rows_ + 2); }

  private:
    std::filesystem::path file_;
    ReadingProcess process_;
    Hdf5Limits limits_;
    std::uint64_t rows_;
    std::uint64_t lines_ = 0;
};

class Hdf5Process {
  public:
    // The program's file, or a name to be looked for in PATH.
    explicit Hdf5Process(std::filesystem::path program) : program_(std::move(program)) {}

    // The format follows from the ending. Errors name the file, and what to do.
    Result<EventSet> read(const std::filesystem::path& file) const;
    Result<EventSet> read(const std::filesystem::path& file, Hdf5Limits limits) const;
    // As io/files/scan_file.hpp has it.
    Result<ScanSet> read_scans(const std::filesystem::path& file, const std::string& dataset) const;
    // Scans, or columns of numbers of any other datasets.
    using Recorded = std::variant<ScanSet, ColumnTextInput>;
    Result<Recorded> read_table(const std::filesystem::path& file, const TableOptions& options) const;
    // `began` is when the events' time was zero.
    Result<void> write(const std::filesystem::path& file, const EventSet& set,
                       std::chrono::system_clock::time_point began,
                       std::chrono::system_clock::time_point now) const;

  private:
    Result<ReadingProcess> start(const std::filesystem::path& file, std::vector<std::string> before,
                                 const std::vector<std::string>& after, const std::string& what) const;

    std::filesystem::path program_;
};

}  // namespace afferent
