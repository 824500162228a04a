#include "afferent/io/files/afferent_table.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace afferent {
namespace {

const Population two_patches{
    .patches = {{"thumb, \"left\"\nhand", 1, "SA1"}, {"index", 2, ""}},
    .afferents = {
        {.place = Position{0.1, -2.5e-7}, .element = 4, .elements = 12}, {.element = 2}, {.element = 3}}};

class AfferentTableFile : public testing::Test {
  protected:
    ~AfferentTableFile() override { std::filesystem::remove(file_); }

    std::string refusal(const std::string& text) const {
        std::ofstream(file_) << text;
        const auto read = read_afferents(file_);
        return read ? "accepted" : read.error().text.substr(file_.string().size());
    }

    const std::filesystem::path file_ =
        std::filesystem::temp_directory_path() / ("afferents-" + std::to_string(getpid()) + ".csv");
    const std::string head_ = "address,patch,kind,x_mm,y_mm,element,elements,resolution_ns\n";
};

TEST_F(AfferentTableFile, ReadsBackEqual) {
    ASSERT_FALSE(write_afferents(file_, two_patches, Duration(100'000)));
    const auto read = read_afferents(file_);
    ASSERT_TRUE(read) << read.error().text;
    EXPECT_EQ(read.value().population, two_patches);
    EXPECT_EQ(read.value().resolution, Duration(100'000));
}

TEST_F(AfferentTableFile, IsATableThatAnyProgramReads) {
    ASSERT_FALSE(write_afferents(file_, two_patches, Duration(1)));
    std::ifstream in(file_);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}),
              head_ +
                  "0,\"thumb, \"\"left\"\"\nhand\",SA1,0.1,-2.5e-07,4,12,1\n"
                  "1,index,,,,2,1,1\n2,index,,,,3,1,1\n");
}

TEST_F(AfferentTableFile, IsRefusedWithTheLineAndTheReason) {
    EXPECT_EQ(refusal(head_ + "0,a,SA1,1,2,0,1,1\r\n"), "accepted");
    EXPECT_EQ(refusal(""),
              ":1: the columns must be address,patch,kind,x_mm,y_mm,element,elements,resolution_ns");
    EXPECT_EQ(refusal(head_ + "0,a,SA1,1,2,0,1,1\n0,a,SA1,1,2,0,1,1\n"),
              ":3: address must count the rows from 0");
    EXPECT_EQ(refusal(head_ + "0,a\n"), ":2: has 2 cells, and must have 8");
    EXPECT_EQ(refusal(head_ + "0,,SA1,1,2,0,1,1\n"), ":2: patch must have a name");
    EXPECT_EQ(refusal(head_ + "0,a,SA1,1,,0,1,1\n"), ":2: x_mm and y_mm must both be given, or none of them");
    EXPECT_EQ(refusal(head_ + "0,a,SA1,1,nan,0,1,1\n"), ":2: x_mm and y_mm must be numbers");
    EXPECT_EQ(refusal(head_ + "0,a,SA1,1,2,-1,1,1\n"), ":2: element and elements must be whole numbers");
    EXPECT_EQ(refusal(head_ + "0,a,SA1,1,2,0,1,0\n"), ":2: resolution_ns must be a whole number > 0");
    EXPECT_FALSE(read_afferents("/nowhere/at/all"));
}

TEST_F(AfferentTableFile, StandsBesideTheEvents) {
    EXPECT_EQ(afferents_beside("out/events.csv"), "out/afferents.csv");
    EXPECT_EQ(afferents_beside("out/r.csv"), "out/r.afferents.csv");
}

}  // namespace
}  // namespace afferent
