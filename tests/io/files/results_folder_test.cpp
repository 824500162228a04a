#include "afferent/io/files/results_folder.hpp"
#include "tests/value_or_throw.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <map>

namespace afferent {
namespace {

namespace fs = std::filesystem;

class ResultsFolderTest : public testing::Test {
  protected:
    ResultsFolderTest() : out_(fs::temp_directory_path() / ("afferent-results-" + std::to_string(getpid()))) {
        fs::remove_all(out_);
    }
    ~ResultsFolderTest() override { fs::remove_all(out_); }

    static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

    ResultsFolder open() const {
        return value_or_throw(ResultsFolder::create(out_, {"events.csv", "force.csv", "summary.json"}));
    }

    // Everything in the folder, by name.
    std::map<std::string, std::string> there() const {
        std::map<std::string, std::string> found;
        for (const auto& entry : fs::directory_iterator(out_)) {
            std::ifstream in(entry.path());
            found[entry.path().filename().string()] = {std::istreambuf_iterator<char>(in), {}};
        }
        return found;
    }

    const fs::path out_;
    using Files = std::map<std::string, std::string>;
};

TEST_F(ResultsFolderTest, PutsTheResultsOfOneRunInPlaceTogether) {
    {
        ResultsFolder first = open();
        write(first.unfinished() / "events.csv", "1");
        write(first.unfinished() / "force.csv", "1");
        write(first.unfinished() / "summary.json", "1");
        ASSERT_TRUE(first.put_in_place());
    }
    write(out_ / "notes.txt", "mine");
    EXPECT_EQ(there(),
              (Files{{"events.csv", "1"}, {"force.csv", "1"}, {"summary.json", "1"}, {"notes.txt", "mine"}}));
    {
        // This run has no forces: those of the first would stand beside its summary.
        ResultsFolder second = open();
        write(second.unfinished() / "events.csv", "2");
        write(second.unfinished() / "summary.json", "2");
        ASSERT_TRUE(second.put_in_place());
    }
    EXPECT_EQ(there(), (Files{{"events.csv", "2"}, {"summary.json", "2"}, {"notes.txt", "mine"}}));
}

TEST_F(ResultsFolderTest, LeavesWhatWasThereWhereARunFails) {
    {
        ResultsFolder first = open();
        write(first.unfinished() / "events.csv", "1");
        write(first.unfinished() / "summary.json", "1");
        ASSERT_TRUE(first.put_in_place());
    }
    {
        ResultsFolder broken = open();
        write(broken.unfinished() / "events.csv", "half");
    }
    EXPECT_EQ(there(), (Files{{"events.csv", "1"}, {"summary.json", "1"}}));
}

// Wherever it fails half-way, there is never a summary beside files of another run.
TEST_F(ResultsFolderTest, TakesAPictureThatComesLater) {
    {
        ResultsFolder results = open();
        write(results.unfinished() / "summary.json", "1");
        ASSERT_TRUE(results.put_in_place());
        write(results.unfinished() / "force.csv", "late");
        EXPECT_TRUE(results.add("force.csv"));
        EXPECT_TRUE(results.add("events.csv")) << "there is none";
    }
    EXPECT_EQ(there(), (Files{{"force.csv", "late"}, {"summary.json", "1"}}));
}

TEST_F(ResultsFolderTest, KeepsWhatIsUnfinishedWhereItIsTold) {
    fs::path unfinished;
    {
        ResultsFolder results = open();
        unfinished = results.unfinished();
        write(unfinished / "events.csv", "1");
        results.keep_unfinished();
    }
    EXPECT_TRUE(fs::exists(unfinished / "events.csv"));
}

TEST_F(ResultsFolderTest, HasNoSummaryWhereItIsIncomplete) {
    fs::create_directories(out_ / "force.csv" / "in the way");
    write(out_ / "summary.json", "old");
    {
        ResultsFolder results = open();
        for (const char* name : {"events.csv", "force.csv", "summary.json"})
            write(results.unfinished() / name, "new");
        const Result<void> put = results.put_in_place();
        ASSERT_FALSE(put);
        EXPECT_NE(put.error().text.find("force.csv: cannot be put in place: "), std::string::npos);
    }
    EXPECT_FALSE(fs::exists(out_ / "summary.json"));
}

TEST_F(ResultsFolderTest, WritesToAPipeOrADeviceAsItIs) {
    fs::create_directories(out_);
    ASSERT_EQ(::mkfifo((out_ / "events.csv").c_str(), 0600), 0);
    {
        ResultsFolder results = open();
        EXPECT_TRUE(fs::is_fifo(results.unfinished() / "events.csv"));
        write(results.unfinished() / "summary.json", "1");
        ASSERT_TRUE(results.put_in_place());
    }
    EXPECT_TRUE(fs::is_fifo(out_ / "events.csv"));
    EXPECT_TRUE(fs::exists(out_ / "summary.json"));
}

TEST_F(ResultsFolderTest, SaysWhereItCannotBe) {
    write(out_, "a file");
    const auto made = ResultsFolder::create(out_ / "deeper", {"summary.json"});
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().text.find("deeper: results cannot be written there: Not a directory"),
              std::string::npos)
        << made.error().text;
}

}  // namespace
}  // namespace afferent
