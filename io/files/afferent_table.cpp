#include "afferent/io/files/afferent_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/table_writer.hpp"

namespace afferent {
namespace {

constexpr std::array<std::string_view, 8> afferent_columns{"address", "patch",   "kind",     "x_mm",
                                                           "y_mm",    "element", "elements", "resolution_ns"};
// As many rows as a scene has afferents at most, of this length.
constexpr std::size_t largest_afferent_table = std::size_t{1} << 31U;

// Takes the rows of a table apart. A cell in quotes may hold commas, line ends and doubled quotes.
class AfferentRows {
  public:
    explicit AfferentRows(std::string_view text) : left_(text) {}

    bool done() const noexcept { return left_.empty(); }
    std::size_t line() const noexcept { return line_; }

    // The cells of the next row.
    std::vector<std::string> take() {
        std::vector<std::string> cells(1);
        bool quoted = false;
        line_ = next_line_;
        while (!left_.empty()) {
            const char c = left_.front();
            left_.remove_prefix(1);
            if (c == '\n') ++next_line_;
            if (c == '"') {
                const bool doubled = quoted && left_.starts_with('"');
                if (doubled) {
                    cells.back() += '"';
                    left_.remove_prefix(1);
                } else {
                    quoted = !quoted;
                }
            } else if (c == ',' && !quoted) {
                cells.emplace_back();
            } else if (c == '\n' && !quoted) {
                break;
            } else if (c != '\r' || quoted) {
                cells.back() += c;
            }
        }
        return cells;
    }

  private:
    std::string_view left_;
    std::size_t line_ = 1;
    std::size_t next_line_ = 1;
};

template <class Number>
bool number_of_cell(const std::string& cell, Number& number) {
    const auto [end, failed] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
    return failed == std::errc() && end == cell.data() + cell.size();
}

// Returns what is wrong with the row.
std::string add_afferent(const std::vector<std::string>& cells, AfferentTable& table) {
    auto& [patches, afferents] = table.population;
    Address address = 0;
    Population::Afferent& each = afferents.emplace_back();
    std::int64_t resolution_ns = 0;
    if (cells.size() != afferent_columns.size())
        return "has " + std::to_string(cells.size()) + " cells, and must have " +
               std::to_string(afferent_columns.size());
    if (!number_of_cell(cells[0], address) || address != afferents.size() - 1)
        return "address must count the rows from 0";
    if (cells[1].empty()) return "patch must have a name";
    if (cells[3].empty() != cells[4].empty()) return "x_mm and y_mm must both be given, or none of them";
    if (!cells[3].empty()) {
        Position& place = each.place.emplace();
        if (!number_of_cell(cells[3], place.x_mm) || !number_of_cell(cells[4], place.y_mm) ||
            !std::isfinite(place.x_mm) || !std::isfinite(place.y_mm))
            return "x_mm and y_mm must be numbers";
    }
    if (!number_of_cell(cells[5], each.element) || !number_of_cell(cells[6], each.elements))
        return "element and elements must be whole numbers";
    if (!number_of_cell(cells[7], resolution_ns) || resolution_ns < 1)
        return "resolution_ns must be a whole number > 0";
    table.resolution = Duration(resolution_ns);
    if (patches.empty() || patches.back().name != cells[1]) patches.push_back({cells[1], 0, cells[2]});
    ++patches.back().afferents;
    return "";
}

}  // namespace

std::filesystem::path afferents_beside(const std::filesystem::path& events) {
    if (events.filename() == "events.csv") return events.parent_path() / "afferents.csv";
    std::filesystem::path beside = events;
    return beside.replace_extension(".afferents.csv");
}

std::optional<TableError> write_afferents(const std::filesystem::path& file, const Population& population,
                                          Duration resolution) {
    TableWriter table(file, afferent_columns);
    std::size_t address = 0;
    for (const Population::Patch& patch : population.patches) {
        for (std::uint32_t i = 0; i < patch.afferents; ++i, ++address) {
            const Population::Afferent& each = population.afferents[address];
            table.cell(std::uint64_t{address});
            table.text(patch.name);
            table.text(patch.kind);
            if (each.place) {
                table.cell(each.place->x_mm);
                table.cell(each.place->y_mm);
            } else {
                table.no_value();
                table.no_value();
            }
            table.cell(std::uint64_t{each.element});
            table.cell(std::uint64_t{each.elements});
            table.cell(static_cast<std::uint64_t>(resolution.count()));
            table.end_row();
        }
    }
    return table.close();
}

Result<AfferentTable> read_afferents(const std::filesystem::path& file) {
    AFFERENT_TRY(in, open_input(file));
    std::string text;
    std::vector<char> piece(std::size_t{1} << 16U);
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), in.get())) {
        text.append(piece.data(), size);
        if (text.size() > largest_afferent_table) break;
    }
    AfferentRows rows(text);
    const auto malformed = [&](const std::string& what) {
        return Error{Error::Kind::malformed, file.string() + ":" + std::to_string(rows.line()) + ": " + what};
    };
    if (std::ferror(in.get()) != 0 || text.size() > largest_afferent_table)
        return malformed("cannot be read, or has more than 2 GB");
    if (const auto head = rows.take(); !std::ranges::equal(head, afferent_columns))
        return malformed("the columns must be address,patch,kind,x_mm,y_mm,element,elements,resolution_ns");
    AfferentTable table;
    while (!rows.done())
        if (const std::string wrong = add_afferent(rows.take(), table); !wrong.empty())
            return malformed(wrong);
    return table;
}

}  // namespace afferent
