// A table as text that is read piece by piece: from a file, or from the program that reads containers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "afferent/io/files/hdf5_process.hpp"
#include "afferent/io/files/scan_set.hpp"
#include "afferent/io/files/table_error.hpp"
#include "afferent/io/files/table_format.hpp"
#include "afferent/io/files/text_input.hpp"

namespace afferent {

class TableInput {
  public:
    static Result<TableInput> open(const std::filesystem::path& file, const TableOptions& options);

    // What a TableReader of the text is to be told.
    const TableOptions& options() const noexcept { return options_; }
    // Fills the buffer, or what of it there is; 0 at the end.
    Result<std::size_t> read(std::span<char> buffer);
    // The fraction of the text that has been read, 0 to 1.
    double fraction() const;
    // What only the input knows: the file's own form, of which the text is made.
    void complete(TableFormat& format) const;
    // Counts rows where the file has no lines.
    TableError place(TableError error) const;

    // In place of text: scans, as io/files/scan_file.hpp has them.
    std::optional<ScanSet> scans;

  private:
    std::string container_;  // "HDF5", ...; empty: the file is text itself
    TableOptions options_;
    std::variant<std::monostate, TextInput, ColumnTextInput> text_;
};

}  // namespace afferent
