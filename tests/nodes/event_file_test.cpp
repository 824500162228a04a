// Tables of events, with and without what is told of their afferents.
#include "afferent/nodes/event_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "afferent/io/files/afferent_table.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/population.hpp"
#include "tests/since_start.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

class EventFiles : public testing::Test {
  protected:
    EventFiles()
        : folder_(std::filesystem::temp_directory_path() /
                  ("afferent-events-" + std::to_string(::getpid()))) {
        std::filesystem::create_directory(folder_);
    }
    ~EventFiles() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path events(const std::string& rows) {
        std::ofstream(folder_ / "events.csv") << "time_s,address\n" << rows;
        return folder_ / "events.csv";
    }

    const std::filesystem::path folder_;
};

TEST_F(EventFiles, AreReadToTheirLastRow) {
    const EventFile read = value_or_throw(read_event_file(events("0.000000001,3\n0.5,0\n0.5,1\n")));
    EXPECT_EQ(read.set.events, (std::vector<Event>{{at(1ns), 3}, {at(500ms), 0}, {at(500ms), 1}}));
    EXPECT_EQ(read.set.resolution, 1ns);
    EXPECT_TRUE(read.set.population.patches.empty());
    EXPECT_TRUE(read.remarks.empty());
}

TEST_F(EventFiles, AreReadTogetherWithTheTableOfTheirAfferents) {
    const Population population =
        population_of(make_plan(Scene::from_text("patch { name: 'thumb' elements: 2 }")));
    const auto file = events("0.25,0\n0.5,1\n");
    ASSERT_FALSE(write_afferents(afferents_beside(file), population, 100us));
    const EventFile read = value_or_throw(read_event_file(file));
    EXPECT_EQ(read.set.events.size(), 2U);
    EXPECT_EQ(read.set.resolution, 100us);
    ASSERT_EQ(read.set.population.patches.size(), 1U);
    EXPECT_EQ(read.set.population.patches[0].name, "thumb");

    const auto other = read_event_file(events("0.25,2\n"));
    ASSERT_FALSE(other);
    EXPECT_NE(other.error().text.find("afferents.csv: does not belong to "), std::string::npos)
        << other.error().text;
}

TEST_F(EventFiles, SayThatARecordingWasBrokenOff) {
    const Plan plan = make_plan(Scene::from_text(
        "duration_s: 1 patch { name: 'thumb' elements: 1 } source { profile { point { force_n: 5 } } } "
        "link { tcp {} }"));
    const auto file = folder_ / "run.afferent";
    for (const bool closes : {true, false}) {
        const auto run = value_or_throw(Run::open(plan, {}));
        value_or_throw(run->record(file, make_hello(plan, false)));
        while (!run->done() && (closes || run->next() < at(900ms))) value_or_throw(run->do_next());
        if (closes) {
            run->finish(plan.end());
            value_or_throw(run->close());
        }
        const EventFile read = value_or_throw(read_event_file(file));
        EXPECT_GT(read.set.events.size(), 10U);
        EXPECT_EQ(read.remarks, closes ? std::vector<std::string>{}
                                       : std::vector{file.string() + ": was not closed, and may end early"});
    }
}

TEST_F(EventFiles, NameTheFileOfWhatIsWrong) {
    const auto file = events("0.25,one\n");
    const auto read = read_event_file(file);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().text.rfind(file.string() + ": line 2", 0), 0U) << read.error().text;
    EXPECT_FALSE(read_event_file(folder_ / "nothing.csv"));
}

}  // namespace
}  // namespace afferent
