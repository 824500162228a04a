// A whole table in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "afferent/io/files/table_error.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

struct Table {
    std::string file;
    std::vector<std::string> columns;  // without time_s
    std::vector<TimePoint> times;
    std::vector<double> values;  // row by row

    std::size_t rows() const noexcept { return times.size(); }
    std::span<const double> row(std::size_t i) const noexcept {
        return std::span(values).subspan(i * columns.size(), columns.size());
    }
};

// Reads by the rules of TableReader. No wanted columns: all but time_s.
[[nodiscard]] std::variant<Table, TableError> read_table(const std::filesystem::path& file,
                                                         std::vector<std::string> wanted = {});

}  // namespace afferent
