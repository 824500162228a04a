#include "afferent/io/recording.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

namespace afferent {
namespace {

namespace fs = std::filesystem;

class Recordings : public testing::Test {
  protected:
    Recordings()
        : file_(fs::temp_directory_path() / ("afferent-" + std::to_string(getpid()) + ".afferent")) {}
    ~Recordings() override { fs::remove(file_); }

    proto::Envelope packet(int i) const {
        proto::Envelope packet;
        packet.set_position(static_cast<std::uint32_t>(i + 1));
        packet.set_payload(std::string(static_cast<std::size_t>(i % 7), 'x'));
        return packet;
    }

    void record(int packets, bool close) {
        proto::Hello hello;
        hello.set_addresses(9);
        auto writer = RecordingWriter::create(file_, hello);
        ASSERT_TRUE(writer) << writer.error().text;
        for (int i = 0; i < packets; ++i) writer.value().write(packet(i));
        EXPECT_TRUE(!close || writer.value().close());
    }

    // How many packets can be read, each as it was written.
    int readable() {
        auto reader = RecordingReader::open(file_);
        if (!reader) return -1;
        EXPECT_EQ(reader.value().hello().addresses(), 9U);
        closed_ = reader.value().closed();
        proto::Envelope message;
        int count = 0;
        for (;;) {
            const Result<bool> next = reader.value().next(message);
            EXPECT_TRUE(next);
            if (!next || !next.value()) return count;
            EXPECT_EQ(message.SerializeAsString(), packet(count).SerializeAsString());
            ++count;
        }
    }

    fs::path file_;
    bool closed_ = false;
};

TEST_F(Recordings, ReadBackEqual) {
    for (const int packets : {0, 1, 200, 5000}) {
        record(packets, true);
        EXPECT_EQ(readable(), packets);
        EXPECT_TRUE(closed_);
    }
}

TEST_F(Recordings, AreReadableToTheLastWholeFrameAfterAKill) {
    record(300, false);
    const auto size = fs::file_size(file_);
    int last = readable();
    EXPECT_EQ(last, 300);
    EXPECT_FALSE(closed_);
    for (auto length = size - 1; length > size - 40; --length) {
        fs::resize_file(file_, length);
        const int now = readable();
        EXPECT_LE(now, last);
        EXPECT_GE(now, last - 1);
        EXPECT_FALSE(closed_);
        last = now;
    }
    EXPECT_LT(last, 300);
}

TEST_F(Recordings, ThatAreNoneAreRefused) {
    EXPECT_FALSE(RecordingReader::open("/nowhere/at/all"));
    std::ofstream(file_) << "time_s,address\n";
    EXPECT_FALSE(RecordingReader::open(file_));
    record(10, true);
    fs::resize_file(file_, 14);
    EXPECT_FALSE(RecordingReader::open(file_));
    EXPECT_FALSE(RecordingWriter::create("/nowhere/at/all", {}));
}

TEST_F(Recordings, ReportAFullDisk) {
    auto writer = RecordingWriter::create("/dev/full", {});
    ASSERT_TRUE(writer);
    for (int i = 0; i < 1000; ++i) writer.value().write(packet(i));
    const Result<void> closed = writer.value().close();
    ASSERT_FALSE(closed);
    EXPECT_EQ(closed.error().text, "/dev/full: cannot be written to its end");
}

}  // namespace
}  // namespace afferent
