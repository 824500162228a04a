#include "afferent/io/files/recorded_events.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

#include "afferent/io/files/recording.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

TEST(RecordedEvents, AreRefusedBeforeAnyHello) {
    const fs::path file =
        fs::temp_directory_path() / ("afferent-events-" + std::to_string(getpid()) + ".afferent");
    proto::RecordingHead head;
    head.set_scene("duration_s: 1");
    {
        auto writer = RecordingWriter::create(file, head);
        ASSERT_TRUE(writer) << writer.error().text;
        proto::Entry packet;
        packet.mutable_link()->set_position(1);
        writer.value().write(packet);
        EXPECT_TRUE(writer.value().close());
    }
    const auto read =
        read_recorded_events(file, [](const PacketCounts&) { FAIL() << "there is no session"; });
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, Error::Kind::malformed);
    EXPECT_EQ(read.error().text, file.string() + ": has packets before any hello");
    fs::remove(file);
}

}  // namespace
}  // namespace afferent
