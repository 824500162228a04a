// Tables as files: written, read back, and refused when the disk or the folder fails.
#include "afferent/io/files/table.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "afferent/io/files/table_writer.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

class TableFile : public ::testing::Test {
  protected:
    TableFile() { fs::create_directories(folder_); }
    ~TableFile() override { fs::remove_all(folder_); }

    fs::path file(const char* name) const { return folder_ / name; }
    static std::string content(const fs::path& file) {
        std::ostringstream text;
        text << std::ifstream(file).rdbuf();
        return text.str();
    }

  private:
    fs::path folder_ =
        fs::path(testing::TempDir()) / ("afferent-table-" + std::to_string(std::random_device()()));
};

TimePoint at_ns(std::int64_t ns) { return scene_start + Duration(ns); }

TEST_F(TableFile, WritesTimesExactlyAndNumbersAsShortAsTheyReadBack) {
    TableWriter writer(file("a.csv"), {"time_s", "a", "b", "c", "d"});
    writer.cell(at_ns(1));
    writer.cell(std::uint64_t{18'446'744'073'709'551'615U});
    writer.cell(0.1);
    writer.cell(2.0 / 3, 4);
    writer.no_value();
    writer.end_row();
    ASSERT_FALSE(writer.close());
    EXPECT_EQ(content(file("a.csv")), "time_s,a,b,c,d\n0.000000001,18446744073709551615,0.1,0.6667,\n");
}

TEST_F(TableFile, WritesEveryTimeThereIs) {
    constexpr auto last = std::numeric_limits<std::int64_t>::max();
    TableWriter writer(file("a.csv"), {"time_s"});
    for (const std::int64_t ns : {std::int64_t{-1}, std::int64_t{1'500'000'000}, last, -last - 1}) {
        writer.cell(at_ns(ns));
        writer.end_row();
    }
    ASSERT_FALSE(writer.close());
    EXPECT_EQ(content(file("a.csv")),
              "time_s\n-0.000000001\n1.500000000\n9223372036.854775807\n-9223372036.854775808\n");
}

TEST_F(TableFile, ReadsBackWhatItWrote) {
    std::mt19937_64 random(1);
    std::vector<TimePoint> times;
    std::vector<double> values;
    TableWriter writer(file("a.csv"), {"time_s", "x", "y"});
    std::int64_t ns = 0;
    for (int i = 0; i < 5000; ++i) {
        ns += 1 + static_cast<std::int64_t>(random() % 100'000'000'000'000U);
        times.push_back(at_ns(ns));
        writer.cell(times.back());
        for (int k = 0; k < 2; ++k) {
            values.push_back(std::normal_distribution(0.0, 1e3)(random));
            writer.cell(values.back());
        }
        writer.end_row();
    }
    ASSERT_FALSE(writer.close());
    const auto read = read_table(file("a.csv"), {.begin = 0ns});
    const auto* const table = std::get_if<Table>(&read);
    ASSERT_TRUE(table) << std::get<TableError>(read).message();
    EXPECT_EQ(table->columns, (std::vector<std::string>{"x", "y"}));
    EXPECT_EQ(table->times, times);
    EXPECT_EQ(table->values, values);
    EXPECT_EQ(table->rows(), 5000U);
    EXPECT_EQ(table->row(7)[1], values[15]);
}

TEST_F(TableFile, GetsItsNameWhenItIsWhole) {
    {
        TableWriter writer(file("a.csv"), {"time_s"});
        writer.cell(at_ns(0));
        writer.end_row();
        EXPECT_FALSE(fs::exists(file("a.csv")));
    }
    EXPECT_FALSE(fs::exists(file("a.csv")));
    EXPECT_EQ(content(file("a.csv.part")), "time_s\n0.000000000\n");
}

TEST_F(TableFile, SaysThatTheDiskIsFull) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    TableWriter writer("/dev/full", {"time_s"});
    for (int i = 0; i < 10'000; ++i) {
        writer.cell(at_ns(i));
        writer.end_row();
    }
    EXPECT_TRUE(writer.error());  // before the end: a run need not go on in vain
    const auto error = writer.close();
    ASSERT_TRUE(error);
    EXPECT_EQ(error->message(), "/dev/full: cannot be written: No space left on device");
}

TEST_F(TableFile, SaysAtCloseThatTheDiskIsFull) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "there is no /dev/full";
    TableWriter writer("/dev/full", {"time_s"});
    EXPECT_FALSE(writer.error());
    EXPECT_TRUE(writer.close());
}

TEST_F(TableFile, SaysThatTheFolderCannotBeWritten) {
    TableWriter writer(file("absent/a.csv"), {"time_s"});
    writer.cell(at_ns(0));
    writer.end_row();
    const auto error = writer.close();
    ASSERT_TRUE(error);
    EXPECT_EQ(error->message(),
              file("absent/a.csv").string() + ": cannot be opened for writing: No such file or directory");
}

TEST_F(TableFile, SaysWhatCannotBeRead) {
    const auto refusal = [](const fs::path& file) {
        return std::get<TableError>(read_table(file)).message();
    };
    EXPECT_EQ(refusal(file("absent.csv")),
              file("absent.csv").string() + ": cannot be read: No such file or directory");
    EXPECT_EQ(refusal(file("")), file("").string() + ": cannot be read: it is a folder; name a file in it");
    std::ofstream(file("bad.csv")) << "time_s,f\n0,1\n1,one\n";
    EXPECT_EQ(refusal(file("bad.csv")),
              file("bad.csv").string() + R"(:3: column "f": "one" is not a number)");
}

TEST_F(TableFile, SaysHowManyValuesAreMissing) {
    std::ofstream(file("a.csv")) << "time_s,f,g\n0,1,2\n1,,3\n2,NaN,\n3,4,5\n";
    const auto refused = read_table(file("a.csv"));
    EXPECT_EQ(std::get<TableError>(refused).message().substr(file("a.csv").string().size(), 71),
              ":3: 3 values are missing in 2 rows, the first of column \"f\" in line 3. ");
    const auto read = read_table(file("a.csv"), {.missing = Missing::skip});
    EXPECT_EQ(std::get<Table>(read).values, (std::vector<double>{1, 2, 4, 5}));
}

TEST_F(TableFile, IsRefusedOrCutWhereItTakesTooMuchMemory) {
    {
        std::ofstream text(file("a.csv"));
        text << "time_s,f,g\n";
        for (int i = 0; i < 1000; ++i) text << i << ",1,2\n";
    }
    const auto refused = read_table(file("a.csv"), {}, {.most_values = 300});
    EXPECT_EQ(
        std::get<TableError>(refused).text,
        "the table has more than 300 values, for which 0 MB are needed; name fewer columns (--columns), or "
        "read a shorter part");
    double done = 0;
    const auto read = read_table(
        file("a.csv"), {}, {.most_values = 300, .cuts = true, .progress = [&](double part) { done = part; }});
    const auto& table = std::get<Table>(read);
    EXPECT_TRUE(table.format.is_cut);
    EXPECT_EQ(table.values.size() + table.times.size(), 300U) << "whole rows";
    EXPECT_EQ(done, 1);
    const auto whole = read_table(file("a.csv"), {}, {.most_values = 3000, .cuts = true});
    EXPECT_FALSE(std::get<Table>(whole).format.is_cut);
    EXPECT_EQ(std::get<TableSpan>(read_span(file("a.csv"))).rows, 1000U);
}

}  // namespace
}  // namespace afferent
