// The writer of a hand's records counts those that it loses.
#include "afferent/nodes/hand_writer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "afferent/io/files/recording.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

// Signs of life would be twenty in a second, more than there are steps; marks of the time are a second apart.
TEST(HandWriter, RecordsAHandOfFewSteps) {
    const Plan plan = make_plan(Scene::from_text(
        "source { profile { point { force_n: 1 } } } link { tcp {} } hand { emg_rate_hz: 2 }"));
    const std::filesystem::path file = testing::TempDir() + "afferent-few-" + std::to_string(::getpid());
    HandWriter writer;
    writer.record(value_or_throw(HandRecording::create(file, plan, proto::HAND, nullptr)));
    HandRecords records(4, {});
    for (std::uint64_t step = 1; step <= 4; ++step) {
        records.make(HandRecord::Kind::step, step)->done.time = scene_start + static_cast<int>(step) * 500ms;
        records.push();
    }
    writer.write(records);
    value_or_throw(writer.close(records, scene_start + 2s));
    RecordingReader reader = value_or_throw(RecordingReader::open(file));
    proto::Entry entry;
    int marks = 0;
    while (value_or_throw(reader.next(entry)) && !entry.has_end()) marks += entry.has_mark();
    EXPECT_EQ(marks, 2);
    std::filesystem::remove(file);
}

// A recording with a hole would give another result when replayed.
TEST(HandWriter, EndsARecordingWithTheLastStepBeforeALostRecord) {
    const Plan plan =
        make_plan(Scene::from_text("source { profile { point { force_n: 1 } } } link { tcp {} }"));
    const std::filesystem::path file = testing::TempDir() + "afferent-writer-" + std::to_string(::getpid());
    for (const bool is_lost : {false, true}) {
        HandWriter writer;
        writer.record(value_or_throw(HandRecording::create(file, plan, proto::HAND, nullptr)));
        HandRecords records(1, {});
        HandRecord* const kept = records.make(HandRecord::Kind::step, 1);
        ASSERT_NE(kept, nullptr);
        kept->done.time = scene_start + 1ms;
        records.push();
        if (is_lost) {
            ASSERT_EQ(records.make(HandRecord::Kind::step, 2), nullptr) << "there is room for one";
        }
        writer.write(records);
        value_or_throw(writer.close(records, scene_start + 2ms));
        proto::Entry entry;
        RecordingReader reader = value_or_throw(RecordingReader::open(file));
        while (value_or_throw(reader.next(entry)) && !entry.has_end()) {
        }
        EXPECT_EQ(Duration(entry.end().time_ns()), is_lost ? Duration(1ms) : Duration(2ms));
    }
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace afferent
