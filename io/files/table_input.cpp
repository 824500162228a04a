#include "afferent/io/files/table_input.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "afferent/io/files/column_text.hpp"
#include "afferent/io/files/sibling_program.hpp"
#include "afferent/io/files/table.hpp"

namespace afferent {
namespace {

struct Container {
    std::string_view ending;
    std::string_view name;
};
constexpr std::array containers{Container{".h5", "HDF5"}, Container{".hdf5", "HDF5"},
                                Container{".mat", "MAT"}, Container{".npz", "NPZ"}, Container{".npy", "NPY"}};

std::string_view container_of(const std::filesystem::path& file) {
    const std::string ending = file.extension().string();
    const auto* const found = std::ranges::find(containers, ending, &Container::ending);
    return found == containers.end() ? "" : found->name;
}

// The text begins with "sep=" and a header.
constexpr std::size_t lines_above_rows = 2;

}  // namespace

bool is_container(const std::filesystem::path& file) { return !container_of(file).empty(); }

Result<TableInput> TableInput::open(const std::filesystem::path& file, const TableOptions& options) {
    TableInput input;
    input.container_ = container_of(file);
    input.options_ = options;
    if (input.container_.empty()) {
        AFFERENT_TRY(text, TextInput::open(file));
        input.text_.emplace<TextInput>(std::move(text));
        return input;
    }
    AFFERENT_TRY(read, Hdf5Process(sibling_program("afferent-hdf5")).read_table(file, options));
    if (auto* const scans = std::get_if<ScanSet>(&read)) {
        input.scans = std::move(*scans);
        return input;
    }
    input.options_ = options_of_column_text(options);
    input.text_.emplace<ColumnTextInput>(std::get<ColumnTextInput>(std::move(read)));
    return input;
}

Result<std::size_t> TableInput::read(std::span<char> buffer) {
    if (auto* const text = std::get_if<TextInput>(&text_)) return text->read(buffer);
    if (auto* const text = std::get_if<ColumnTextInput>(&text_)) return text->read(buffer);
    return std::size_t{0};
}

double TableInput::fraction() const {
    if (const auto* const text = std::get_if<TextInput>(&text_)) return text->fraction();
    if (const auto* const text = std::get_if<ColumnTextInput>(&text_)) return text->fraction();
    return 1;
}

void TableInput::complete(TableFormat& format) const {
    format.container = container_;
    if (const auto* const text = std::get_if<TextInput>(&text_)) format.compressed = text->compressed();
    if (!container_.empty() && format.missing.rows != 0) format.missing.first_line -= lines_above_rows;
}

TableError TableInput::place(TableError error) const {
    if (container_.empty() || error.line == 0) return error;
    if (error.line > lines_above_rows)
        error.text.insert(0, "row " + std::to_string(error.line - lines_above_rows) + ": ");
    error.line = 0;
    return error;
}

}  // namespace afferent
