// Tables of MATLAB, and groups of datasets, as text for a TableReader.
#include "afferent/io/files/mat_file.hpp"

#include <gtest/gtest.h>
#include <matio.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <random>
#include <utility>

namespace afferent {
namespace {

class MatFileTest : public testing::TestWithParam<mat_ft> {
  protected:
    MatFileTest()
        : file_(std::filesystem::path(testing::TempDir()) /
                ("afferent-" + std::to_string(std::random_device()()) + ".mat")),
          mat_(Mat_CreateVer(file_.c_str(), nullptr, GetParam())) {}
    ~MatFileTest() override { std::filesystem::remove(file_); }

    static matvar_t* variable(const char* name, std::size_t rows, std::size_t columns,
                              std::vector<double> values) {
        std::array<std::size_t, 2> size{rows, columns};
        return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size.data(), values.data(), 0);
    }
    void write(matvar_t* variable) {
        Mat_VarWrite(mat_, variable, MAT_COMPRESSION_ZLIB);
        Mat_VarFree(variable);
    }
    // The text without its head, or the error.
    std::string sent(const TableOptions& options = {}) {
        if (mat_) Mat_Close(std::exchange(mat_, nullptr));
        std::string bytes;
        const auto result = send_mat(file_, options, [&](std::span<const std::byte> piece) {
            bytes.append(reinterpret_cast<const char*>(piece.data()), piece.size());
        });
        return result ? bytes.substr(sizeof(ColumnTextHead)) : result.error().text;
    }

  private:
    std::filesystem::path file_;
    mat_t* mat_;
};

TEST_P(MatFileTest, ReadsColumnsThatStandOrLie) {
    write(variable("t_ms", 1, 3, {0, 4, 8}));
    write(variable("f_n", 3, 2, {0.1, 0.2, 0.3, 1, 2, 3}));
    write(variable("rate", 1, 1, {250}));
    EXPECT_EQ(sent(), "sep=\t\n\"t_ms\"\t\"f_1_n\"\t\"f_2_n\"\n0\t0.1\t1\n4\t0.2\t2\n8\t0.3\t3\n");
    EXPECT_EQ(sent({.columns = {"f_2_n"}}), "sep=\t\n\"t_ms\"\t\"f_2_n\"\n0\t1\n4\t2\n8\t3\n");
}

TEST_P(MatFileTest, ReadsTheFieldsOfAStructure) {
    std::array<std::size_t, 2> one{1, 1};
    for (const char* const name : {"left", "right"}) {
        std::array<const char*, 2> fields{"t_ms", "f_n"};
        matvar_t* const structure = Mat_VarCreateStruct(name, 2, one.data(), fields.data(), fields.size());
        Mat_VarSetStructFieldByName(structure, "t_ms", 0, variable(nullptr, 2, 1, {0, 4}));
        Mat_VarSetStructFieldByName(structure, "f_n", 0,
                                    variable(nullptr, 2, 1, {1, name[0] == 'l' ? 2.0 : 3.0}));
        write(structure);
    }
    EXPECT_EQ(sent({.columns = {"right/f_n"}}), "sep=\t\n\"t_ms\"\t\"f_n\"\n0\t1\n4\t3\n");
    EXPECT_EQ(
        sent(),
        "the file's root has no datasets of numbers, and these groups have: left/ (t_ms, f_n); right/ "
        "(t_ms, f_n). Name the columns with their group (--columns left/NAME), or its time (--time-column "
        "left/NAME)");
}

INSTANTIATE_TEST_SUITE_P(OfVersion, MatFileTest, testing::Values(MAT_FT_MAT5, MAT_FT_MAT73),
                         [](const auto& version) { return version.param == MAT_FT_MAT5 ? "5" : "7_3"; });

TEST(MatFile, RefusesWhatIsNone) {
    const auto result = send_mat(AFFERENT_SOURCE_DIR "/README.md", {}, [](std::span<const std::byte>) {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().text, "is no file of MATLAB, or is cut off");
}

// However many rows a dataset has, pieces of the same size are read.
TEST(ColumnText, IsSentInPiecesOfBoundedSize) {
    constexpr std::uint64_t rows = 1'000'000;
    std::uint64_t next = 0;
    std::size_t largest_read = 0;
    std::size_t largest_piece = 0;
    std::uint64_t lines = 0;
    const auto result =
        send_columns({{.name = "run/t_ms",
                       .rows = rows,
                       .columns = 1,
                       .read =
                           [&](std::uint64_t first, std::span<double> values) {
                               EXPECT_EQ(first, next);
                               next += values.size();
                               largest_read = std::max(largest_read, values.size());
                               for (std::size_t i = 0; i < values.size(); ++i)
                                   values[i] = static_cast<double>(first + i);
                               return success();
                           }},
                      {.name = "run/f_n",
                       .rows = rows,
                       .columns = 3,
                       .read =
                           [](std::uint64_t, std::span<double> values) {
                               std::ranges::fill(values, 0.125);
                               return success();
                           }}},
                     {}, [&](std::span<const std::byte> piece) {
                         largest_piece = std::max(largest_piece, piece.size());
                         lines += static_cast<std::uint64_t>(std::ranges::count(piece, std::byte{'\n'}));
                     });
    EXPECT_TRUE(result);
    EXPECT_EQ(next, rows);
    EXPECT_EQ(lines, rows + 2);
    EXPECT_LE(largest_read, std::size_t{1} << 15U);
    EXPECT_LT(largest_piece, std::size_t{2} << 20U);
}

TEST(ColumnText, EndsWithTheReasonWhyThereIsNoMore) {
    std::string bytes;
    const auto result =
        send_columns({{.name = "f_n",
                       .rows = 3,
                       .columns = 1,
                       .read = [](std::uint64_t, std::span<double>) -> Result<void> {
                           return Error{Error::Kind::malformed, "is damaged"};
                       }}},
                     {.rate_hz = 100}, [&](std::span<const std::byte> piece) {
                         bytes.append(reinterpret_cast<const char*>(piece.data()), piece.size());
                     });
    EXPECT_TRUE(result);
    EXPECT_EQ(bytes.substr(sizeof(ColumnTextHead)), "sep=\t\n\"f_n\"\n\x18is damaged");
}

}  // namespace
}  // namespace afferent
