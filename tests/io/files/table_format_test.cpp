// What tables are taken for that were made elsewhere.
#include "afferent/io/files/table_format.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "afferent/io/files/column_unit.hpp"
#include "afferent/io/files/table.hpp"
#include "afferent/io/files/table_reader.hpp"

namespace afferent {
namespace {

struct FoundTable {
    std::vector<std::string> columns;
    std::vector<double> times_s;
    std::vector<std::vector<double>> rows;
    TableFormat format;
    std::string error = "none";
};

FoundTable found_in(std::string_view text, TableOptions options = {}, std::size_t piece = std::string::npos) {
    TableReader reader("t.csv", std::move(options));
    FoundTable found;
    const auto keep = [&](const TableRow& row) {
        found.times_s.push_back(seconds(row.time));
        found.rows.emplace_back(row.values.begin(), row.values.end());
    };
    std::optional<TableError> error;
    for (std::size_t at = 0; at < text.size() && !error; at += std::min(piece, text.size() - at))
        error = reader.feed(text.substr(at, piece), keep);
    if (!error) error = reader.finish(keep);
    if (error) found.error = error->message();
    found.columns = reader.columns();
    found.format = reader.format();
    return found;
}

using Rows = std::vector<std::vector<double>>;
using Times = std::vector<double>;

TEST(TableForms, OfEverySeparatorGiveTheSameTable) {
    for (const std::string separator : {",", ";", "\t", " ", "   "}) {
        std::string text = "time_s,a,b\n0,1.5,2\n0.5,3,4.25\n";
        for (std::size_t at; (at = text.find(',')) != std::string::npos;) text.replace(at, 1, "|");
        for (std::size_t at; (at = text.find('|')) != std::string::npos;) text.replace(at, 1, separator);
        for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, text.size()}) {
            const FoundTable found = found_in(text, {}, piece);
            EXPECT_EQ(found.error, "none") << separator;
            EXPECT_EQ(found.columns, (std::vector<std::string>{"a", "b"}));
            EXPECT_EQ(found.times_s, (Times{0, 0.5}));
            EXPECT_EQ(found.rows, (Rows{{1.5, 2}, {3, 4.25}}));
            EXPECT_EQ(found.format.separator, separator[0]);
        }
    }
}

TEST(TableForms, HaveTheDecimalMarkOfTheirFirstNumberWithOne) {
    const FoundTable comma = found_in("t;a;b\n0;1;2\n0,004;1,25;-3e-1\n");
    EXPECT_EQ(comma.error, "none");
    EXPECT_EQ(comma.rows, (Rows{{1, 2}, {1.25, -0.3}}));
    EXPECT_EQ(comma.times_s, (Times{0, 0.004}));
    EXPECT_EQ(comma.format.decimal_mark, ',');
    EXPECT_EQ(comma.format.decimal_mark_line, 3U);
    EXPECT_EQ(found_in("t_s;a\n0;1,234\n").rows, (Rows{{1.234}})) << "a thousand has no mark";
    EXPECT_EQ(
        found_in("t_s;a\n0;1.5\n1;1,5\n").error,
        R"(t.csv:3: column "a": "1,5" has a comma, and the decimal mark is a point since line 2; thousands )"
        "have no mark");
    EXPECT_EQ(
        found_in("t_s;a\n0;1.234,5\n").error,
        R"(t.csv:2: column "a": "1.234,5" has a comma, and the decimal mark is a point since line 2; thousands )"
        "have no mark");
    EXPECT_EQ(found_in("t_s;a\n0;1,234,567\n").error, R"(t.csv:2: column "a": "1,234,567" is not a number)");
    EXPECT_EQ(found_in("t_s,a\n0,\"1,5\"\n").error, R"(t.csv:2: column "a": "1,5" is not a number)");
}

TEST(TableForms, HaveTimeInAnyUnitByTheNameOfItsColumn) {
    struct Named {
        std::string column;
        TimeUnit unit;
        double three_of_it_s;
    };
    for (const auto& [name, unit, three_of_it_s] :
         std::vector<Named>{{"time_s", TimeUnit::seconds, 3},
                            {"t_ms", TimeUnit::milliseconds, 0.003},
                            {"Time [ms]", TimeUnit::milliseconds, 0.003},
                            {"TIME(us)", TimeUnit::microseconds, 3e-6},
                            {"t/ms", TimeUnit::milliseconds, 0.003},
                            {"Zeit in s", TimeUnit::seconds, 3},
                            {"timestamp_us", TimeUnit::microseconds, 3e-6},
                            {"Timestamp (\xC2\xB5s)", TimeUnit::microseconds, 3e-6},
                            {"ts_ns", TimeUnit::nanoseconds, 3e-9},
                            {"elapsed time [min]", TimeUnit::minutes, 180},
                            {"Seconds", TimeUnit::seconds, 3}}) {
        const FoundTable found = found_in("f_n;" + name + "\n1;0\n2;3\n");
        EXPECT_EQ(found.error, "none") << name;
        EXPECT_EQ(found.format.time_unit, unit) << name;
        EXPECT_EQ(found.format.time_column, name);
        ASSERT_EQ(found.times_s.size(), 2U);
        EXPECT_DOUBLE_EQ(found.times_s[1], three_of_it_s) << name;
        EXPECT_EQ(found.columns, std::vector<std::string>{"f_n"});
    }
    EXPECT_EQ(found_in("contact time_n,f\n0,1\n").error.rfind("t.csv:1: there is no column \"time_s\"", 0),
              0U);
}

TEST(TableForms, WithoutAUnitOfTimeAreOfSecondsOrRefused) {
    const FoundTable found = found_in("t,f_n\n0,1\n0.1,2\n5,3\n");
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.times_s, (Times{0, 0.1, 5}));
    EXPECT_FALSE(found.format.unit_is_said);
    EXPECT_EQ(found_in("time,f_n\n0,1\n").times_s, (Times{0})) << "a single row";
    const std::string text = "t,f_n\n0,1\n4,2\n";
    EXPECT_EQ(found_in(text).error,
              "t.csv:3: column \"t\": no unit is said, and a step of 4 may be of milliseconds as well as of "
              "seconds: "
              "call the column \"t_ms\" or \"t_s\", or say time_unit (--time-unit ms)");
    EXPECT_EQ(found_in(text, {.time_unit = TimeUnit::milliseconds}).times_s, (Times{0, 0.004}));
}

TEST(TableForms, ThatBeginLateOrSince1970BeginAt0) {
    const FoundTable late = found_in("time_s,f\n1000.5,1\n1000.504,2\n");
    EXPECT_EQ(late.times_s, (Times{0, 0.004}));
    EXPECT_EQ(late.format.begin, 1000500ms);
    EXPECT_FALSE(late.format.since_1970);
    EXPECT_EQ(found_in("time_s,f\n9.999,1\n").times_s, (Times{9.999})) << "a stretch of nothing";
    for (const std::string time :
         {"1763820000.125", "1763820000125", "1763820000125000", "1763820000125000000"}) {
        const std::string next = time.substr(0, time.size() - 1) + "9";
        const FoundTable found = found_in("timestamp,f\n" + time + ",1\n" + next + ",2\n");
        EXPECT_EQ(found.error, "none") << time;
        ASSERT_FALSE(found.times_s.empty()) << time;
        EXPECT_EQ(found.times_s[0], 0) << time;
        EXPECT_TRUE(found.format.since_1970);
    }
    // 2025-11-22T14:00:00Z is 1763820000 s after 1970.
    const FoundTable dates =
        found_in("date;f\n2025-11-22T14:00:00.125Z;1\n2025-11-22 15:00:00,250+01:00;2\n2025/11/22 14:01;3\n");
    EXPECT_EQ(dates.error, "none");
    EXPECT_EQ(dates.times_s, (Times{0, 0.125, 59.875}));
    EXPECT_EQ(dates.format.begin, 1763820000125ms);
    for (const std::string date : {"2025-11-22T19:30:00+05:30", "2025-11-22T10:30:00-0330",
                                   "2025-11-22T14:00Z", "2025-11-22T16:00+02"})
        EXPECT_EQ(found_in("date,f\n" + date + ",1\n").format.begin, 1763820000s) << date;
    EXPECT_EQ(
        found_in("date,f\n2025-11-22T14:00:00Z,1\n2025-11-31T14:00:00Z,1\n").error,
        "t.csv:3: column \"date\": \"2025-11-31T14:00:00Z\" is not a date such as 2026-11-22T14:03:07.125Z, "
        "nor a time of day such as 14:03:07.125");
}

TEST(TableForms, BeginWhereOneSays) {
    const std::string text = "time_s,f\n-0.5,1\n0,2\n0.5,3\n20,4\n";
    EXPECT_EQ(found_in(text, {.begin = -500ms}).times_s, (Times{0, 0.5, 1, 20.5}));
    EXPECT_EQ(found_in(text, {.begin = 250ms}).times_s, (Times{0.25, 19.75})) << "rows before it are skipped";
    EXPECT_EQ(found_in(text, {.begin = 21s}).error,
              "t.csv: all rows are before begin_s, where the scene begins");
}

TEST(TableForms, OfRowsWithoutTimeTakeARate) {
    const FoundTable found = found_in("a_v\tb_v\n1\t2\n3\t4\n5\t6\n", {.rate_hz = 250});
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.times_s, (Times{0, 0.004, 0.008}));
    EXPECT_EQ(found.columns, (std::vector<std::string>{"a_v", "b_v"}));
}

TEST(TableForms, MayHaveCommentsAndBlankLinesAtTheirEnd) {
    const FoundTable found = found_in("# six sensors\n%\n\"time_s\";a\n# now\n0;1\n1;2\n\n \t\n");
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.rows, (Rows{{1}, {2}}));
    EXPECT_EQ(found.format.header_line, 3U);
    EXPECT_EQ(found_in("time_s,a\n0,1\n\n1,2\n").error, "t.csv:3: the line is blank");
    EXPECT_EQ(found_in("sep=;\ntime_s;a,b\n0;1\n").columns, std::vector<std::string>{"a,b"});
}

TEST(TableForms, WithoutAHeaderCountTheirColumnsOrTakeTheCommentAbove) {
    const FoundTable saved = found_in("# made by NumPy\n# t_ms f_n\n0.0e+00 1.5e+00\n4.0e+00 2.5e+00\n");
    EXPECT_EQ(saved.error, "none");
    EXPECT_EQ(saved.columns, std::vector<std::string>{"f_n"});
    EXPECT_EQ(saved.times_s, (Times{0, 0.004}));
    const FoundTable bare =
        found_in("0,5 1,25\n0,75 1,5\n", {.time_column = "1", .time_unit = TimeUnit::seconds});
    EXPECT_EQ(bare.error, "none");
    EXPECT_EQ(bare.columns, std::vector<std::string>{"2"});
    EXPECT_EQ(bare.rows, (Rows{{1.25}, {1.5}}));
    EXPECT_EQ(bare.format.header_line, 0U);
}

TEST(TableForms, SayThatTwoColumnsMayBeTime) {
    EXPECT_EQ(found_in("t,timestamp_ms,f\n0,0,1\n").error,
              "t.csv:1: columns \"t\" and \"timestamp_ms\" may both be time: say which by time_column "
              "(--time-column)");
    EXPECT_EQ(found_in("t,timestamp_ms,f\n0,0,1\n", {.columns = {"f"}, .time_column = "timestamp_ms"}).error,
              "none");
    EXPECT_EQ(found_in("t,f\n0,1\n", {.time_column = "x"}).error,
              R"(t.csv:1: there is no column "x"; the columns are "t", "f")");
}

TEST(TableForms, AreToldInSentences) {
    const FoundTable found = found_in("Time [ms];a\n1000000;0,5\n1000004;1\n");
    EXPECT_EQ(found.format.sentences(),
              (std::vector<std::string>{
                  "Semicolons separate its columns.",
                  "The decimal mark is a comma, as the first number with one has it, in line 2.",
                  "Time is in column \"Time [ms]\", in ms.", "The table's time 1000 s is the scene's 0."}));
}

TEST(ColumnUnits, AreFoundInNames) {
    const auto is = [](std::string_view column, Quantity quantity, double factor) {
        const auto unit = unit_of_column(column);
        return unit && unit->quantity == quantity && unit->factor == factor;
    };
    EXPECT_TRUE(is("force_n", Quantity::force, 1));
    EXPECT_TRUE(is("F1 [mN]", Quantity::force, 1e-3));
    EXPECT_TRUE(is("F/N", Quantity::force, 1));
    EXPECT_TRUE(is("adc0_counts", Quantity::counts, 1));
    EXPECT_TRUE(is("FSR 3 (V)", Quantity::volts, 1));
    EXPECT_TRUE(is("EMG [\xC2\xB5V]", Quantity::volts, 1e-6));
    for (const char* column : {"force", "F [kg]", "weight_g", "n", "", "[", "]", "_n_", "F [", "F ]"})
        EXPECT_FALSE(unit_of_column(column)) << column;
    EXPECT_EQ(named_unit("Grip Force [N]").name, "grip force");
    EXPECT_EQ(named_unit("U in V").name, "u");
}

// Made by `printf 'time_s;a\n0;1,5\n1;2\n' | gzip -n9`.
constexpr unsigned char gzipped[]{0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00,
                                  0x00, 0x02, 0x03, 0x2b, 0xc9, 0xcc, 0x4d};

class CompressedTable : public testing::Test {
  protected:
    std::filesystem::path file_ = std::filesystem::path(testing::TempDir()) /
                                  ("t" + std::to_string(std::random_device()()) + ".csv.gz");
    void TearDown() override { std::filesystem::remove(file_); }
    void gzip(const std::string& text) const {
        const std::filesystem::path plain = file_.parent_path() / file_.stem();
        std::ofstream(plain) << text;
        ASSERT_EQ(std::system(("gzip -nf9 '" + plain.string() + "'").c_str()), 0);
    }
    std::string refusal() const {
        const auto read = read_table(file_);
        const auto* error = std::get_if<TableError>(&read);
        return error ? error->text : "none";
    }
};

TEST_F(CompressedTable, IsReadAsItIs) {
    gzip("time_s;a\n0;1,5\n1;2\n");
    const auto read = read_table(file_);
    const auto* const table = std::get_if<Table>(&read);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->values, (std::vector<double>{1.5, 2}));
    EXPECT_TRUE(table->format.compressed);
    EXPECT_EQ(table->span().length(), 2s) << "the last row is as long as that before it";
}

TEST_F(CompressedTable, ThatIsCutOrDamagedIsRefused) {
    std::string rows = "time_s,a\n";
    for (int i = 0; i < 2000; ++i) rows += std::to_string(i) + ',' + std::to_string(i * i % 977) + '\n';
    gzip(rows);
    const auto size = std::filesystem::file_size(file_);
    std::filesystem::resize_file(file_, size - 3);
    EXPECT_EQ(refusal(), "the end is missing of what gzip has compressed");
    gzip(rows);
    {
        std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(size / 2));
        file.write("\0\0\0\0\0\0\0\0", 8);
    }
    EXPECT_NE(refusal(), "none");
    {
        std::ofstream file(file_, std::ios::binary);
        file.write(reinterpret_cast<const char*>(gzipped), sizeof gzipped);
    }
    EXPECT_EQ(refusal(), "the end is missing of what gzip has compressed");
}

// The same text in UTF-16, with its mark of byte order or without.
std::string in_utf16(std::u16string_view text, bool high_byte_first) {
    std::string bytes;
    for (const char16_t unit : text) {
        const char high = static_cast<char>(unit >> 8U);
        const char low = static_cast<char>(unit & 0xFFU);
        bytes += high_byte_first ? high : low;
        bytes += high_byte_first ? low : high;
    }
    return bytes;
}

TEST(TableForms, InUtf16AreReadAsTheSameTextInUtf8) {
    for (const std::u16string mark : {u"\uFEFF", u""})
        for (const bool high_byte_first : {false, true})
            for (const std::size_t piece : {1, 3, 1000}) {
                const FoundTable found = found_in(
                    in_utf16(mark + u"t_s;Druck \u00B5 \U0001F590\r\n0;1,5\r\n0,5;2\r\n", high_byte_first),
                    {}, piece);
                EXPECT_EQ(found.error, "none");
                EXPECT_EQ(found.columns, std::vector<std::string>{"Druck \u00B5 \U0001F590"});
                EXPECT_EQ(found.rows, (Rows{{1.5}, {2}}));
                EXPECT_TRUE(found.format.utf16);
            }
    EXPECT_EQ(found_in(in_utf16(u"\uFEFFt,f\n0,\xDC00\n", false)).error,
              "t.csv:1: the line is no text in UTF-16, as which the table begins");
}

TEST(TableForms, HaveUnitsOnALineOfTheirOwn) {
    const FoundTable found = found_in("Zeit;F1;F2_n;note\nms;[mN];;\n0;1;2;\n4;3;4;\n");
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.columns, (std::vector<std::string>{"F1 [mN]", "F2_n"}));
    EXPECT_EQ(found.times_s, (Times{0, 0.004}));
    EXPECT_EQ(found.rows, (Rows{{1, 2}, {3, 4}}));
    EXPECT_EQ(found.format.units_line, 2U);
    EXPECT_EQ(found.format.header_line, 1U);
    EXPECT_EQ(found.format.ignored_columns, std::vector<std::string>{"note"});
    // A column has both names.
    for (const std::string name : {"F1", "F1 [mN]"})
        EXPECT_EQ(found_in("Zeit;F1\nms;mN\n0;1\n", {.columns = {name}}).columns,
                  std::vector<std::string>{"F1 [mN]"});
    EXPECT_EQ(found_in("F1,F2\nN,N\n1,2\n", {.rate_hz = 10}).columns,
              (std::vector<std::string>{"F1 [N]", "F2 [N]"}));
}

TEST(TableForms, MayHaveOtherLinesAboveTheirHeader) {
    const FoundTable found =
        found_in("Logger 5.2\nDate;22/11/2026\nSerial;12345\n\nTime [ms];F1;F2\n0;1;2\n4;3;4\n");
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.columns, (std::vector<std::string>{"F1", "F2"}));
    EXPECT_EQ(found.rows, (Rows{{1, 2}, {3, 4}}));
    EXPECT_EQ(found.format.header_line, 5U);
    EXPECT_TRUE(found.format.has_preamble);
    EXPECT_FALSE(found_in("t_s,f\n0,1\n").format.has_preamble);
    // What has no column of time says so of the line that is most like a header.
    EXPECT_EQ(found_in("Logger\nx,f\n0,1\n").error.substr(0, 40),
              "t.csv:2: there is no column \"time_s\"; th");
    std::string long_text;
    for (int i = 0; i < 200; ++i) long_text += "a line\n";
    EXPECT_EQ(found_in(long_text).error.substr(0, 24), "t.csv:100: there is no c");
}

TEST(TableForms, IgnoreColumnsOfText) {
    const FoundTable found = found_in("time_s,state,f,remark,g_n,empty\n0,rest,,,1,\n1,hold,2,good,3,\n",
                                      {.missing = Missing::skip});
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.columns, (std::vector<std::string>{"f", "g_n"}));
    EXPECT_EQ(found.format.ignored_columns, (std::vector<std::string>{"state", "remark", "empty"}));
    EXPECT_EQ(found.rows, (Rows{{2, 3}}));
    EXPECT_EQ(found_in("time_s,f,g_n\n0,1,ERR\n").error, R"(t.csv:2: column "g_n": "ERR" is not a number)");
    EXPECT_EQ(found_in("time_s,state,f\n0,rest,1\n", {.columns = {"state"}}).error,
              R"(t.csv:2: column "state": "rest" is not a number)");
}

TEST(TableForms, SkipRowsThatLackAValueOrInterpolateThem) {
    const std::string text = "time_s,a,b\n0,,1\n1,2,NaN\n2,4,--\n4,N/A,7\n,0,0\n5,6,\n6,8,9\n7,,\n";
    const FoundTable skipped = found_in(text, {.missing = Missing::skip});
    EXPECT_EQ(skipped.error, "none");
    EXPECT_EQ(skipped.rows, (Rows{{8, 9}}));
    EXPECT_EQ(skipped.format.missing.values, 8U);
    EXPECT_EQ(skipped.format.missing.rows, 7U);
    EXPECT_EQ(skipped.format.said_of_missing(),
              "8 values are missing in 7 rows, the first of column \"a\" in line 2: such rows are left out");
    const FoundTable drawn = found_in(text, {.missing = Missing::interpolate});
    EXPECT_EQ(drawn.error, "none");
    EXPECT_EQ(drawn.times_s, (Times{0, 1, 2, 4, 5, 6, 7}));
    // b: 1 at 0 s and 7 at 4 s; a: 4 at 2 s and 6 at 5 s.
    EXPECT_EQ(drawn.rows, (Rows{{2, 1}, {2, 2.5}, {4, 4}, {4 + 2 * (2.0 / 3), 7}, {6, 8}, {8, 9}, {8, 9}}));
    EXPECT_EQ(found_in("time_s,a\n0,-\n1,-\n", {.missing = Missing::interpolate}).error,
              "t.csv:4: a column has no value at all: leave it out (--columns)");
    EXPECT_EQ(found_in("time_s,a\n0,-\n1,-\n", {.missing = Missing::skip}).error,
              "t.csv: a value is missing in every row");
}

// A column that stays empty must not hold all rows back.
TEST(TableForms, BoundTheRowsThatWaitForAValue) {
    TableReader reader("t.csv", {.missing = Missing::interpolate});
    ASSERT_FALSE(reader.feed("time_s,a,b\n0,1,1\n", [](const TableRow&) {}));
    std::optional<TableError> error;
    std::size_t rows = 0;
    for (; !error && rows < 10'000'000; ++rows)
        error = reader.feed(std::to_string(rows + 1) + ",1,\n", [](const TableRow&) {});
    EXPECT_EQ(rows, RowCompleter::most_waiting / 2 + 1);
}

TEST(TableForms, HaveTimesOfDayThatPassMidnight) {
    const FoundTable found = found_in("Time;f\n23:59:59.25;1\n23:59:59.75;2\n00:00:00.5;3\n");
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.times_s, (Times{0, 0.5, 1.25}));
    EXPECT_TRUE(found.format.times_of_day);
    EXPECT_FALSE(found.format.since_1970);
    EXPECT_EQ(found_in("time,f\n2:03:07 PM,1\n2:03:08 pm,2\n").format.begin, 14h + 3min + 7s);
    EXPECT_EQ(found_in("elapsed,f\n00:00:01.5,1\n").times_s, (Times{1.5}));
    EXPECT_EQ(found_in("time,f\n25:00:00,1\n").error.substr(0, 53),
              "t.csv:2: column \"time\": \"25:00:00\" is not a number");
    EXPECT_EQ(found_in("time,f\n12:00:00,1\n11:00:00,2\n").error,
              "t.csv:3: column \"time\": \"11:00:00\" is before the row above: time runs backwards");
}

TEST(TableForms, HaveDateAndTimeInTwoColumns) {
    const FoundTable found = found_in("Date,f,Time\n2026-11-22,1,23:59:59.5\n2026-11-23,2,00:00:00.5\n");
    EXPECT_EQ(found.error, "none");
    EXPECT_EQ(found.columns, std::vector<std::string>{"f"});
    EXPECT_EQ(found.times_s, (Times{0, 1}));
    EXPECT_EQ(found.format.date_column, "Date");
    EXPECT_EQ(found.format.time_column, "Time");
    EXPECT_TRUE(found.format.since_1970);
}

// 2026-11-22T14:03:07Z is 1795356187 s after 1970.
TEST(TableForms, AskForTheOrderOfADateThatMayBeTwo) {
    for (const std::string date : {"22/11/2026 14:03:07", "11/22/2026 2:03:07 PM", "22.11.2026 14:03:07,000",
                                   "22-11-2026 14:03:07", "2026/11/22 14:03:07"}) {
        const FoundTable found = found_in("date;f\n" + date + ";1\n");
        EXPECT_EQ(found.error, "none") << date;
        EXPECT_EQ(found.format.begin, 1795356187s) << date;
    }
    EXPECT_EQ(found_in("date;f\n30.11.2026 00:00;1\n01.12.2026 00:00;2\n").times_s, (Times{0, 86400}));
    EXPECT_EQ(found_in("date;f\n30/11/2026 00:00;1\n01/12/2026 00:00;2\n").times_s, (Times{0, 86400}));
    const std::string text = "date;f\n03/04/2026 00:00;1\n04/04/2026 00:00;2\n";
    EXPECT_EQ(found_in(text).error,
              "t.csv:2: column \"date\": \"03/04/2026 00:00\" may be of that day or of that month: say "
              "time_unit (--time-unit day-first or month-first)");
    EXPECT_EQ(found_in(text, {.time_unit = TimeUnit::day_first}).times_s, (Times{0, 86400}));
    EXPECT_EQ(found_in(text, {.time_unit = TimeUnit::month_first}).times_s, (Times{0, 31 * 86400}));
}

}  // namespace
}  // namespace afferent
