#include "afferent/io/files/recording.hpp"
#include "tests/value_or_throw.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <random>

namespace afferent {
namespace {

namespace fs = std::filesystem;

class Recordings : public testing::Test {
  protected:
    Recordings()
        : file_(fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + ".afferent")) {}
    ~Recordings() override { fs::remove(file_); }

    // Packets, and a mark in place of every hundredth.
    static proto::Entry entry(int i) {
        proto::Entry entry;
        if (i % 100 == 99) {
            entry.set_step(static_cast<std::uint64_t>(i));
            entry.mutable_mark()->set_time_ns(std::int64_t{i} * 1'000'000);
        } else {
            entry.mutable_link()->set_position(static_cast<std::uint32_t>(i + 1));
            entry.mutable_link()->set_payload(std::string(static_cast<std::size_t>(i % 7), 'x'));
        }
        return entry;
    }

    static proto::RecordingHead head(const std::string& scene = "duration_s: 1") {
        proto::RecordingHead head;
        head.set_scene(scene);
        head.set_has_steps(true);
        return head;
    }

    void record(int entries, bool close, const std::string& scene = "duration_s: 1") {
        auto writer = RecordingWriter::create(file_, head(scene));
        ASSERT_TRUE(writer) << writer.error().text;
        for (int i = 0; i < entries; ++i) writer.value().write(entry(i));
        EXPECT_TRUE(!close || writer.value().close());
    }

    // How many entries can be read, each as it was written; -1 if the file is refused.
    int readable() {
        auto reader = RecordingReader::open(file_);
        if (!reader) return -1;
        EXPECT_TRUE(reader.value().head().has_steps());
        closed_ = reader.value().closed();
        proto::Entry read;
        for (int count = 0;; ++count) {
            const Result<bool> next = reader.value().next(read);
            EXPECT_TRUE(next);
            if (!next || !next.value()) return count;
            EXPECT_EQ(read.SerializeAsString(), entry(count).SerializeAsString());
        }
    }

    // Changes a byte, counted from the end of the file.
    void change(std::uintmax_t from_end) {
        std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
        const auto at = static_cast<std::streamoff>(fs::file_size(file_) - from_end);
        file.seekg(at);
        const char before = static_cast<char>(file.get());
        file.seekp(at);
        file.put(static_cast<char>(before ^ 0x10));
    }

    fs::path file_;
    bool closed_ = false;
};

TEST_F(Recordings, ReadBackEqual) {
    for (const int entries : {0, 1, 200, 5000}) {
        record(entries, true);
        EXPECT_EQ(readable(), entries);
        EXPECT_TRUE(closed_);
    }
}

TEST_F(Recordings, HoldLongScenes) {
    const std::string scene(most_recorded_scene, 's');
    record(3, true, scene);
    EXPECT_EQ(value_or_throw(RecordingReader::open(file_)).head().scene(), scene);
    EXPECT_EQ(readable(), 3);
    const auto refused = RecordingWriter::create(file_, head(scene + "s"));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text.find("2^20"), std::string::npos) << refused.error().text;
}

TEST_F(Recordings, AreWholeUpToTheLastEntryWithoutBeingClosed) {
    auto writer = RecordingWriter::create(file_, head());
    ASSERT_TRUE(writer);
    for (int i = 0; i < 50; ++i) {
        writer.value().write(entry(i));
        EXPECT_EQ(readable(), i + 1);
    }
    EXPECT_FALSE(closed_);
}

TEST_F(Recordings, AreReadableToTheLastWholeEntryAfterAKill) {
    record(300, false);
    const auto size = fs::file_size(file_);
    int last = readable();
    EXPECT_EQ(last, 300);
    EXPECT_FALSE(closed_);
    for (auto length = size - 1; length > size - 60; --length) {
        fs::resize_file(file_, length);
        const int now = readable();
        EXPECT_LE(now, last);
        EXPECT_GE(now, last - 1);
        EXPECT_FALSE(closed_);
        last = now;
    }
    EXPECT_LT(last, 300);
}

TEST_F(Recordings, AreReadableWhereTheirIndexIsCut) {
    record(300, true);
    const auto size = fs::file_size(file_);
    for (auto length = size - 1; length > size - 70; --length) {
        fs::resize_file(file_, length);
        EXPECT_GE(readable(), 298) << size - length;
        EXPECT_FALSE(closed_);
    }
}

TEST_F(Recordings, FindTheirMarksWithAndWithoutAnIndex) {
    for (const bool closed : {true, false}) {
        record(1000, closed);
        auto opened = RecordingReader::open(file_);
        ASSERT_TRUE(opened);
        RecordingReader& reader = opened.value();
        proto::Entry read;
        ASSERT_TRUE(reader.next(read));
        const auto marks = reader.marks();
        ASSERT_TRUE(marks) << marks.error().text;
        ASSERT_EQ(marks.value().size(), 10U);
        ASSERT_TRUE(reader.next(read));
        EXPECT_EQ(read.SerializeAsString(), entry(1).SerializeAsString()) << "where it was before";
        EXPECT_EQ(marks.value()[4].time, scene_start + 499ms);
        ASSERT_TRUE(reader.go_to(marks.value()[4]));
        ASSERT_TRUE(reader.next(read));
        EXPECT_EQ(read.SerializeAsString(), entry(499).SerializeAsString());
        for (const RecordedMark& wrong : {RecordedMark{marks.value()[4].time, 1'000'000'000},
                                          {marks.value()[4].time, 3},
                                          {marks.value()[4].time, marks.value()[5].offset}})
            EXPECT_FALSE(reader.go_to(wrong));
    }
}

TEST_F(Recordings, SayWhereTheyAreDamaged) {
    record(300, false);
    change(20);
    auto reader = RecordingReader::open(file_);
    ASSERT_TRUE(reader);
    proto::Entry read;
    Result<bool> next = true;
    while (next && next.value()) next = reader.value().next(read);
    ASSERT_FALSE(next);
    EXPECT_NE(next.error().text.find("the entry at byte"), std::string::npos) << next.error().text;
}

TEST_F(Recordings, ThatAreNoneAreRefused) {
    EXPECT_FALSE(RecordingReader::open("/nowhere/at/all"));
    EXPECT_FALSE(RecordingReader::open(fs::temp_directory_path()));
    std::ofstream(file_) << "time_s,address\n";
    EXPECT_FALSE(RecordingReader::open(file_));
    fs::remove(file_);
    record(10, true);
    fs::resize_file(file_, 14);
    EXPECT_FALSE(RecordingReader::open(file_));
    EXPECT_FALSE(RecordingWriter::create("/nowhere/at/all", {}));
}

TEST_F(Recordings, ReportAFullDisk) {
    auto writer = RecordingWriter::create("/dev/full", head());
    ASSERT_TRUE(writer);
    for (int i = 0; i < 1000; ++i) writer.value().write(entry(i));
    const Result<void> closed = writer.value().close();
    ASSERT_FALSE(closed);
    EXPECT_EQ(closed.error().text, "/dev/full: cannot be written to its end: No space left on device");
}

TEST_F(Recordings, SurviveAnyChange) {
    record(400, true);
    std::ifstream in(file_, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    std::mt19937_64 random(1);
    for (int repeat = 0; repeat < 300; ++repeat) {
        std::string changed = whole.substr(0, repeat % 2 == 0 ? whole.size() : random() % whole.size());
        for (int i = 0; i < 3 && !changed.empty(); ++i)
            changed[random() % changed.size()] = static_cast<char>(random());
        std::ofstream(file_, std::ios::binary) << changed;
        auto reader = RecordingReader::open(file_);
        if (!reader) continue;
        proto::Entry read;
        for (int entries = 0; entries <= 500; ++entries) {
            ASSERT_LT(entries, 500);
            const Result<bool> next = reader.value().next(read);
            if (!next || !next.value()) break;
        }
        (void)reader.value().marks().has_value();
    }
}

TEST_F(Recordings, WriteOverNothingElse) {
    std::ofstream(file_) << "duration_s: 1  # somebody's scene";
    const auto writer = RecordingWriter::create(file_, head());
    ASSERT_FALSE(writer);
    EXPECT_NE(writer.error().text.find("is not overwritten"), std::string::npos);
    EXPECT_GT(fs::file_size(file_), 0U);
    fs::resize_file(file_, 0);
    record(10, true);
    record(20, false);
    EXPECT_EQ(readable(), 20);
}

TEST_F(Recordings, HaveNoMarksBeforeTheStart) {
    for (const bool close : {true, false}) {
        auto writer = RecordingWriter::create(file_, head());
        ASSERT_TRUE(writer);
        proto::Entry mark;
        mark.mutable_mark()->set_time_ns(std::numeric_limits<std::int64_t>::min());
        writer.value().write(mark);
        if (close) {
            EXPECT_TRUE(writer.value().close());
        }
        auto reader = RecordingReader::open(file_);
        ASSERT_TRUE(reader);
        EXPECT_FALSE(reader.value().marks());
    }
}

}  // namespace
}  // namespace afferent
