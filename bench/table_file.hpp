// A table of results with cells that are names as well as numbers.
#pragma once

#include <charconv>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace afferent::bench {

// The shortest digits that read back as the same number.
inline std::string number(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

// Throws std::runtime_error where it cannot be written.
class TableFile {
  public:
    TableFile(const std::filesystem::path& path, const std::vector<std::string>& columns) : path_(path) {
        std::error_code ignored;
        std::filesystem::create_directories(path.parent_path(), ignored);
        file_.open(path);
        row(columns);
    }

    // Cells hold no quotes and no line breaks; one with a comma is quoted.
    void row(const std::vector<std::string>& cells) {
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const bool quoted = cells[i].find(',') != std::string::npos;
            file_ << (i > 0 ? "," : "") << (quoted ? "\"" : "") << cells[i] << (quoted ? "\"" : "");
        }
        file_ << '\n' << std::flush;  // what is known so far outlives an interrupt
        check();
    }

    void close() {
        file_.close();
        check();
    }

  private:
    void check() const {
        if (!file_) throw std::runtime_error(path_.string() + ": cannot be written");
    }

    std::filesystem::path path_;
    std::ofstream file_;
};

// The rows of such a table, each cell with the name of its column. Throws std::runtime_error where there is
// none.
inline std::vector<std::vector<std::pair<std::string, std::string>>> read_rows(
    const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path.string() + ": cannot be read");
    std::vector<std::string> columns;
    std::vector<std::vector<std::pair<std::string, std::string>>> rows;
    for (std::string line; std::getline(file, line);) {
        std::vector<std::string> cells(1);
        bool quoted = false;
        for (const char c : line) {
            if (c == '"')
                quoted = !quoted;
            else if (c == ',' && !quoted)
                cells.emplace_back();
            else
                cells.back() += c;
        }
        if (columns.empty()) {
            columns = std::move(cells);
            continue;
        }
        auto& row = rows.emplace_back();
        for (std::size_t i = 0; i < columns.size() && i < cells.size(); ++i)
            row.emplace_back(columns[i], std::move(cells[i]));
    }
    return rows;
}

}  // namespace afferent::bench
