#include "afferent/io/files/table_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace afferent {
namespace {

struct Read {
    std::vector<std::string> columns;
    std::vector<std::int64_t> times_ns;
    std::vector<std::size_t> lines;
    std::vector<std::vector<double>> rows;
    std::string error = "none";
};

// In pieces of the given size, as they might come through a pipe.
Read read(std::string_view text, std::vector<std::string> wanted = {},
          std::size_t piece = std::string::npos) {
    TableReader reader("t.csv", std::move(wanted));
    Read result;
    const auto keep = [&](const TableRow& row) {
        result.times_ns.push_back(row.time.time_since_epoch().count());
        result.lines.push_back(row.line);
        result.rows.emplace_back(row.values.begin(), row.values.end());
    };
    std::optional<TableError> error;
    for (std::size_t at = 0; at < text.size() && !error; at += std::min(piece, text.size() - at))
        error = reader.feed(text.substr(at, piece), keep);
    if (!error) error = reader.finish();
    if (error) result.error = error->message();
    result.columns = reader.columns();
    return result;
}

std::string refusal(std::string_view text, std::vector<std::string> wanted = {}) {
    return read(text, std::move(wanted)).error;
}

TEST(TableReader, ReadsTimesToTheNanosecondAndNumbersExactly) {
    const Read table = read("time_s,force_n\n0,0.1\n0.000000001,-2.5e-3\n31536000.123456789,1e300\n");
    EXPECT_EQ(table.error, "none");
    EXPECT_EQ(table.columns, std::vector<std::string>{"force_n"});
    EXPECT_EQ(table.times_ns, (std::vector<std::int64_t>{0, 1, 31'536'000'123'456'789}));
    EXPECT_EQ(table.rows, (std::vector<std::vector<double>>{{0.1}, {-2.5e-3}, {1e300}}));
    EXPECT_EQ(table.lines, (std::vector<std::size_t>{2, 3, 4}));
}

TEST(TableReader, ReadsTheSameInPiecesOfAnySize) {
    const std::string_view text = "\xEF\xBB\xBFtime_s,\"a,b\",c\r\n0,1,2\r\n\"0.5\", 3 ,4\r\n1,5,6\r\n";
    const Read whole = read(text);
    EXPECT_EQ(whole.error, "none");
    EXPECT_EQ(whole.columns, (std::vector<std::string>{"a,b", "c"}));
    EXPECT_EQ(whole.rows, (std::vector<std::vector<double>>{{1, 2}, {3, 4}, {5, 6}}));
    for (std::size_t piece = 1; piece < text.size(); ++piece) {
        const Read parts = read(text, {}, piece);
        EXPECT_EQ(parts.error, "none");
        EXPECT_EQ(parts.rows, whole.rows);
        EXPECT_EQ(parts.times_ns, whole.times_ns);
    }
}

TEST(TableReader, HandsOverARowWithItsNewline) {
    TableReader reader("standard input");
    int rows = 0;
    const auto count = [&](const TableRow&) { ++rows; };
    EXPECT_FALSE(reader.feed("time_s,f\n0,1", count));
    EXPECT_EQ(rows, 0);
    EXPECT_FALSE(reader.feed("\n", count));
    EXPECT_EQ(rows, 1);
}

TEST(TableReader, GivesTheWantedColumnsInTheWantedOrder) {
    const Read table = read("note,b,time_s,a\nx,1,0,2\n,3,1,4\n", {"a", "b"});
    EXPECT_EQ(table.error, "none");
    EXPECT_EQ(table.rows, (std::vector<std::vector<double>>{{2, 1}, {4, 3}}));
}

TEST(TableReader, RefusesAHeaderThatLacksAColumn) {
    const std::string what_to_do =
        ". Say which is time by time_column (--time-column), or how many rows a second has by rate_hz "
        "(--rate-hz)";
    EXPECT_EQ(refusal("when,f\n0,1\n"),
              R"(t.csv:1: there is no column "time_s"; the columns are "when", "f")" + what_to_do);
    EXPECT_EQ(refusal("time_s,f\n0,1\n", {"g"}),
              R"(t.csv:1: there is no column "g"; the columns are "time_s", "f")");
    EXPECT_EQ(refusal("time_s,f,f\n0,1,1\n"), R"(t.csv:1: two columns are named "f")");
    EXPECT_EQ(refusal("time_s\n0\n"), R"(t.csv:1: there is no column but "time_s")");
    EXPECT_EQ(refusal("0,1\n1,1\n"),
              R"(t.csv:1: there is no column "time_s"; the columns are "1", "2")" + what_to_do);
}

TEST(TableReader, RefusesARowOfAnotherLength) {
    EXPECT_EQ(refusal("time_s,f\n0,1\n1\n"), "t.csv:3: the row has 1 fields, the header 2");
    EXPECT_EQ(refusal("time_s,f\n0,1,\n"), "t.csv:2: the row has 3 fields, the header 2");
    EXPECT_EQ(refusal("time_s,f\n0,1\n\n1,1\n"), "t.csv:3: the line is blank");
}

TEST(TableReader, RefusesWhatIsNotAFiniteNumber) {
    const auto row = [](const std::string& field) { return refusal("time_s,f\n0," + field + "\n"); };
    const std::string advice = "; missing (--missing skip or interpolate) says what to do about it";
    EXPECT_EQ(row(""), R"(t.csv:2: column "f": the field is empty)" + advice);
    for (const std::string field : {"x", "1.2.3", "1 2", "0x10", "1e", "--1", "1,5", "+-1"})
        EXPECT_NE(row('"' + field + '"').find("is not a number"), std::string::npos) << field;
    for (const std::string field : {"nan", "-nan", "NaN", "NA", "n/a", "null", "-", "--"})
        EXPECT_EQ(row(field), R"(t.csv:2: column "f": ")" + field + "\" is no number" + advice);
    for (const std::string field : {"inf", "-inf", "infinity"})
        EXPECT_EQ(row(field), R"(t.csv:2: column "f": ")" + field + "\" is not finite");
    EXPECT_EQ(row("1e999"), R"(t.csv:2: column "f": "1e999" is beyond the range of numbers)");
    EXPECT_EQ(row("12abc"), R"(t.csv:2: column "f": "12abc" is not a number)");
    EXPECT_LT(row(std::string(100'000, 'x')).size(), 120U);
}

TEST(TableReader, RefusesTimeThatDoesNotRise) {
    EXPECT_EQ(refusal("time_s,f\n1,1\n0.5,1\n"),
              R"(t.csv:3: column "time_s": 0.5 s is before the row above: time runs backwards)");
    EXPECT_EQ(refusal("time_s,f\n1,1\n1.0,1\n"),
              R"(t.csv:3: column "time_s": 1.0 s is the time of the row above too: no sample lasts 0 s)");
    EXPECT_EQ(
        refusal("time_s,f\n-1,1\n"),
        R"(t.csv:2: column "time_s": a table begins at 0 s or later, not at -1; begin_s (--begin-s) says at which time of the table the scene begins)");
    EXPECT_EQ(refusal("time_s,f\n0,1\n1e10,1\n"), R"(t.csv:3: column "time_s": 1e10 s is beyond 292 years)");
    EXPECT_EQ(refusal("time_s,f\nnan,1\n"), R"(t.csv:2: column "time_s": "nan" is not finite)");
}

TEST(TableReader, RefusesATableWithoutRows) {
    EXPECT_EQ(refusal(""), "t.csv: the table is empty");
    EXPECT_EQ(refusal("time_s,f\n"), "t.csv: the table has a header and no rows");
    EXPECT_EQ(refusal("\n"), "t.csv:1: the line is blank");
}

// Wherever a table was cut, no number is read that may have lost digits.
TEST(TableReader, LeavesOutALastLineThatMayBeCutOff) {
    const std::string_view text = "time_s,f\n0,1.25\n1,1.50\n";
    EXPECT_EQ(refusal(text.substr(0, 15)), "t.csv:2: the last line is cut off: it has no newline");
    for (std::size_t size = 0; size < text.size(); ++size)
        EXPECT_EQ(refusal(text.substr(0, size)) == "none", size >= 16) << size;
    for (std::size_t size = 16; size < text.size(); ++size) {
        TableReader reader("t.csv");
        std::vector<double> values;
        const auto keep = [&](const TableRow& row) { values.push_back(row.values[0]); };
        EXPECT_FALSE(reader.feed(text.substr(0, size), keep));
        EXPECT_FALSE(reader.finish(keep));
        EXPECT_EQ(values, std::vector{1.25}) << size;
        EXPECT_EQ(reader.format().left_out_line, size == 16 ? 0U : 3U) << size;
    }
}

TEST(TableReader, RefusesOtherFormatsAtOnce) {
    using namespace std::string_view_literals;
    EXPECT_EQ(refusal("\x89PNG\r\n\x1a\n\0\0\0\rIHDR"sv),
              "t.csv:2: this is not a table of text: it has a byte of value 26");
    EXPECT_NE(refusal("PK\x03\x04 [Content_Types].xml").find("t.csv: this is a spreadsheet (.xlsx, .ods)"),
              std::string::npos);
    EXPECT_NE(refusal("PAR1\x15\x04").find("t.csv: this is a Parquet file: write it as CSV"),
              std::string::npos);
    EXPECT_NE(refusal("MATLAB 5.0 MAT-file, Platform: GLNXA64\0"sv).find("t.csv: this is a file of MATLAB"),
              std::string::npos);
    EXPECT_NE(refusal("\x89HDF\r\n\x1a\n"sv).find("t.csv: this is a file in HDF5: call it .h5"),
              std::string::npos);
    EXPECT_EQ(refusal("time_s,f\n0,\0\n"sv),
              "t.csv:2: this is not a table of text: it has a byte of value 0");
    EXPECT_EQ(refusal("time_s,f\r0,1\r1,1\r"), "t.csv:1: the last line is cut off: it has no newline");
    EXPECT_EQ(refusal("time_s,f\r0,1\r1,1\r\n"), "t.csv:1: a carriage return stands inside the line");
    EXPECT_EQ(refusal("time_s,f\n0,\"1\n1,1\n"), "t.csv:2: a quotation mark is out of place");
    EXPECT_EQ(refusal("time_s,f\n0,1\"2\n"), "t.csv:2: a quotation mark is out of place");
}

// A column for each tactile afferent of a body, in another order than the wanted one. Searching for each
// among all of them would take a minute.
TEST(TableReader, FindsItsColumnsAmongAsManyAsABodyHasAfferents) {
    constexpr std::size_t columns = 230'000;
    std::string header;
    std::string row;
    std::vector<std::string> wanted;
    for (std::size_t i = 0; i < columns; ++i) {
        wanted.push_back(std::to_string(i).append("_n"));
        header.append(wanted.back()).append(",");
        row.append(std::to_string(i % 10)).append(",");
    }
    std::reverse(wanted.begin(), wanted.end());
    const Read table = read(header + "time_s\n" + row + "0\n", wanted);
    EXPECT_EQ(table.error, "none");
    ASSERT_EQ(table.rows.size(), 1U);
    for (std::size_t i = 0; i < columns; ++i)
        ASSERT_EQ(table.rows[0][columns - 1 - i], static_cast<double>(i % 10));
}

TEST(TableReader, BoundsTheLengthOfALine) {
    TableReader reader("t.csv");
    const std::string piece(1 << 20, '1');
    std::optional<TableError> error;
    int pieces = 0;
    for (; pieces < 100 && !error; ++pieces) error = reader.feed(piece, [](const TableRow&) {});
    EXPECT_EQ(pieces, 5);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->message(), "t.csv:1: the line is longer than 4194304 bytes");
}

TEST(TableReader, StaysWithItsFirstError) {
    TableReader reader("t.csv");
    int rows = 0;
    const auto count = [&](const TableRow&) { ++rows; };
    EXPECT_TRUE(reader.feed("time_s,f\n0,1\n0,1\n", count));
    EXPECT_TRUE(reader.feed("2,1\n", count));
    EXPECT_EQ(reader.finish().value().line, 3U);
    EXPECT_EQ(rows, 1);
}

}  // namespace
}  // namespace afferent
