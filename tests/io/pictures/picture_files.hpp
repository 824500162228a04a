// The files of a picture that a test has drawn, and what stands in them.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "afferent/io/pictures/gnuplot.hpp"

namespace afferent {

class Picture : public ::testing::Test {
  protected:
    void SetUp() override {
        if (run_gnuplot("").outcome == Drawn::no_gnuplot) GTEST_SKIP() << "gnuplot is not installed";
        std::filesystem::create_directories(folder_);
    }
    ~Picture() override { std::filesystem::remove_all(folder_); }

    void expect_drawn(const Drawing& drawing) const {
        ASSERT_EQ(drawing.outcome, Drawn::done) << drawing.message;
        EXPECT_EQ(drawing.message, "");
        EXPECT_EQ(first_bytes(".png"), "\x89PNG");
        EXPECT_EQ(first_bytes(".svg"), "<?xm");
    }
    std::string first_bytes(const char* ending) const {
        std::string bytes(4, ' ');
        std::ifstream(stem().string() + ending, std::ios::binary).read(bytes.data(), 4);
        return bytes;
    }
    // How far from the top a text stands, in pixels.
    double height_in_svg(const std::string& text) const {
        std::ifstream in(stem().string() + ".svg");
        double height = 0;
        for (std::string line; std::getline(in, line);) {
            if (const std::size_t moved = line.find("translate("); moved != std::string::npos)
                height = std::stod(line.substr(line.find(',', moved) + 1));
            if (line.find("<text>") != std::string::npos && line.find('>' + text + '<') != std::string::npos)
                return height;
        }
        return -1;
    }
    // How often it stands there as a text of its own.
    int times_in_svg(const std::string& text) const {
        std::ifstream in(stem().string() + ".svg");
        int times = 0;
        for (std::string line; std::getline(in, line);)
            for (std::size_t at = line.find("<text>");
                 at != std::string::npos && (at = line.find('>', at)) != std::string::npos; ++at) {
                const std::string shown = line.substr(at + 1, line.find('<', at) - at - 1);
                const std::size_t first = shown.find_first_not_of(' ');
                times += first != std::string::npos &&
                         shown.substr(first, shown.find_last_not_of(' ') + 1 - first) == text;
            }
        return times;
    }
    // A name that a shell or a careless script would trip over.
    std::filesystem::path stem() const { return folder_ / "it's a $(picture)"; }

  private:
    std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                    ("afferent-picture-" + std::to_string(std::random_device()()));
};

}  // namespace afferent
