// Files of events and of scans in HDF5, read and written by a separate program, afferent-hdf5. The library
// for HDF5 was written for trusted files: others make it run forever or crash. In a process of its own it
// does no harm, and this program need not load it.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <variant>

#include "afferent/io/files/column_set.hpp"
#include "afferent/io/files/event_set.hpp"
#include "afferent/io/files/scan_set.hpp"

namespace afferent {

struct Hdf5Limits {
    std::chrono::seconds processor_time;
    std::uint64_t memory_mb;
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
    // Scans, or columns of numbers of any other datasets, in HDF5, NPZ or NPY.
    using Recorded = std::variant<ScanSet, ColumnSet>;
    Result<Recorded> read_table(const std::filesystem::path& file, const TableOptions& options) const;
    // `began` is when the events' time was zero.
    Result<void> write(const std::filesystem::path& file, const EventSet& set,
                       std::chrono::system_clock::time_point began,
                       std::chrono::system_clock::time_point now) const;

  private:
    // What it says of the file, of which it needs to know what stands behind the limits.
    Result<std::vector<std::byte>> read_bytes(const std::filesystem::path& file,
                                              std::vector<std::string> before,
                                              const std::vector<std::string>& after,
                                              const std::string& what) const;

    std::filesystem::path program_;
};

}  // namespace afferent
