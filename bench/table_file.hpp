// A table of results with cells that are names as well as numbers.
#pragma once

#include <charconv>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
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
        file_ << '\n';
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

}  // namespace afferent::bench
