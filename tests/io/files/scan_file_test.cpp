// Recorded scans in HDF5.
#include "afferent/io/files/scan_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "afferent/io/files/hdf5.hpp"
#include "afferent/io/files/scan_set.hpp"

namespace afferent {
namespace {

class ScanFile : public testing::Test {
  protected:
    ScanFile()
        : path_(std::filesystem::temp_directory_path() /
                ("afferent-scans-" + std::to_string(getpid()) + ".h5")),
          file_(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)),
          group_(H5Gcreate2(file_.id(), "run", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)) {}
    ~ScanFile() override { std::filesystem::remove(path_); }

    // The numbers 0, 1, 2, ... in single precision.
    hdf5::Dataset count(const char* name, std::vector<hsize_t> dimensions) const {
        std::size_t size = 1;
        for (const hsize_t dimension : dimensions) size *= dimension;
        std::vector<float> values(size);
        std::iota(values.begin(), values.end(), 0.0F);
        const hdf5::Space space(
            H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr));
        hdf5::Dataset made(
            H5Dcreate2(group_.id(), name, H5T_IEEE_F32LE, space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        H5Dwrite(made.id(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        return made;
    }

    Result<ScanSet> read(const std::string& dataset) {
        group_.close();
        file_.close();
        std::vector<std::byte> bytes;
        const auto read = read_scans(path_, dataset, [&](std::span<const std::byte> more) {
            bytes.insert(bytes.end(), more.begin(), more.end());
        });
        if (!read) return read.error();
        return ScanSet::of(std::move(bytes));
    }

    std::string why_not(const std::string& dataset) {
        const auto set = read(dataset);
        return set ? "accepted" : set.error().text;
    }

    std::filesystem::path path_;
    hdf5::File file_;
    hdf5::Group group_;
};

TEST_F(ScanFile, HasAValueForEachElementAtItsTime) {
    count("force_n", {3, 4});
    hdf5::write_column(group_.id(), "time_s", std::vector<double>{0.5, 0.75, 2});
    const auto set = read("run/force_n");
    ASSERT_TRUE(set) << set.error().text;
    EXPECT_EQ(set.value().scans(), 3U);
    EXPECT_EQ(set.value().columns(), 4U);
    EXPECT_FALSE(set.value().is_image());
    EXPECT_EQ(set.value().time_s(1), 0.75);
    std::vector<double> values(4);
    set.value().copy(2, values);
    EXPECT_EQ(values, (std::vector<double>{8, 9, 10, 11}));
}

TEST_F(ScanFile, HasImagesAtARate) {
    const hdf5::Dataset images = count("force_n", {2, 3, 2});
    hdf5::write_attribute(images.id(), "rate_hz", 40.0);
    const auto set = read("/run/force_n");
    ASSERT_TRUE(set) << set.error().text;
    EXPECT_TRUE(set.value().is_image());
    EXPECT_EQ(set.value().rows(), 3U);
    EXPECT_EQ(set.value().time_s(1), 0.025);
    std::vector<double> values(6);
    set.value().copy(1, values);
    EXPECT_EQ(values.front(), 6);
    EXPECT_EQ(values.back(), 11);
}

TEST_F(ScanFile, IsRefusedInWords) {
    count("flat", {3});
    count("untimed", {3, 2});
    const hdf5::Dataset stopped = count("stopped", {3, 2});
    hdf5::write_attribute(stopped.id(), "rate_hz", 0.0);
    count("longer", {4, 2});
    hdf5::Group other(H5Gcreate2(file_.id(), "other", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    std::swap(other, group_);
    count("short", {3, 2});
    hdf5::write_column(group_.id(), "time_s", std::vector<double>{0, 1});
    other.close();
    for (const auto& [dataset, expected] : std::vector<std::pair<std::string, std::string>>{
             {"run/none", "run/none is missing"},
             {"nowhere/force_n", "nowhere is missing"},
             {"run", "run is not a dataset"},
             {"run/flat", "run/flat must have two dimensions"},
             {"run/untimed", "run/untimed has no attribute rate_hz, and run/time_s is missing"},
             {"run/stopped", "rate_hz that is not above 0"},
             {"other/short", "other/time_s has 2 times, and other/short has 3 scans"}})
        EXPECT_NE(why_not(dataset).find(expected), std::string::npos) << why_not(dataset);
}

// The bytes may come from a program that has read a hostile file.
TEST(ScanSet, IsRefusedWhereItsBytesDoNotFit) {
    const auto bytes_of = [](ScanSet::Head head, const std::vector<double>& numbers) {
        const auto begin = std::as_bytes(std::span(&head, 1));
        const auto rest = std::as_bytes(std::span(numbers));
        std::vector<std::byte> bytes(begin.begin(), begin.end());
        bytes.insert(bytes.end(), rest.begin(), rest.end());
        return bytes;
    };
    const ScanSet::Head head{.scans = 2, .columns = 1};
    const std::vector<std::byte> whole = bytes_of(head, {0, 1, 5, 6});
    ASSERT_TRUE(ScanSet::of(whole));
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_FALSE(ScanSet::of({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)})) << size;
    for (const std::vector<double>& numbers : {std::vector<double>{0, 0, 5, 6},
                                               {-1, 1, 5, 6},
                                               {0, std::nan(""), 5, 6},
                                               {0, std::numeric_limits<double>::infinity(), 5, 6},
                                               {0, 1, 5, 6, 7}})
        EXPECT_FALSE(ScanSet::of(bytes_of(head, numbers)));
    constexpr std::uint64_t huge = std::uint64_t{1} << 63;
    for (const ScanSet::Head& wrong :
         {ScanSet::Head{.format = 1, .scans = 2, .columns = 1}, ScanSet::Head{.scans = 0, .columns = 1},
          ScanSet::Head{.scans = 2, .columns = 0}, ScanSet::Head{.scans = huge, .columns = 2},
          ScanSet::Head{.scans = 2, .rows = huge, .columns = 2}, ScanSet::Head{.scans = 2, .columns = huge}})
        EXPECT_FALSE(ScanSet::of(bytes_of(wrong, {0, 1, 5, 6})));
}

}  // namespace
}  // namespace afferent
