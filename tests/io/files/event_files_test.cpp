#include "afferent/io/files/event_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "tests/since_start.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

std::vector<Event> some_events(Duration resolution, std::uint64_t steps) {
    std::mt19937_64 random(1);
    std::vector<Event> events(2000);
    for (Event& event : events)
        event = {at(static_cast<std::int64_t>(random() % steps) * resolution),
                 static_cast<Address>(random())};
    events.push_back(events.back());
    std::sort(events.begin(), events.end());
    return events;
}

std::string text(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
std::vector<std::byte> bytes(std::string_view text) {
    const auto view = std::as_bytes(std::span(text));
    return {view.begin(), view.end()};
}

TEST(EventFiles, ReadBackEqual) {
    for (const auto& [format, resolution, steps] :
         {std::tuple(EventFormat::csv, Duration(1ns), 1ULL << 60),
          std::tuple(EventFormat::event_stream, Duration(1us), 1ULL << 32),
          std::tuple(EventFormat::event_stream, Duration(1us), 1000ULL),
          std::tuple(EventFormat::aedat2, Duration(1us), 1ULL << 32)}) {
        const auto events = some_events(resolution, steps);
        const auto written = write_events(events, format);
        ASSERT_TRUE(written);
        const auto read = read_events(written.value(), format);
        ASSERT_TRUE(read) << read.error().text;
        EXPECT_EQ(read.value(), events);
        EXPECT_TRUE(value_or_throw(read_events(value_or_throw(write_events({}, format)), format)).empty());
    }
}

TEST(EventFiles, AreWhatTheFormatsSay) {
    const std::vector<Event> events{{at(1us), 258}, {at(600us), 3}};
    EXPECT_EQ(text(value_or_throw(write_events(events, EventFormat::csv))),
              "time_s,address\n0.000001000,258\n0.000600000,3\n");
    // 599 us are two overflows of 254 and 91.
    EXPECT_EQ(text(value_or_throw(write_events(events, EventFormat::event_stream))),
              std::string("Event Stream\x02\0\0\0\x01\x08\x02\x01\0\0\xff\xff\x5b\x08\x03\0\0\0", 30));
    const std::string aedat = text(value_or_throw(write_events(events, EventFormat::aedat2)));
    EXPECT_EQ(aedat.substr(0, 14), "#!AER-DAT2.0\r\n");
    EXPECT_EQ(aedat.substr(aedat.size() - 16),
              std::string("\0\0\x01\x02\0\0\0\x01\0\0\0\x03\0\0\x02\x58", 16));
}

TEST(EventFiles, SayWhereTheyAreWrong) {
    const auto refusal = [](std::string_view file, EventFormat format) {
        const auto read = read_events(bytes(file), format);
        return read ? std::string("accepted") : read.error().text;
    };
    EXPECT_EQ(refusal("", EventFormat::csv), "line 1: the header must be time_s,address");
    EXPECT_EQ(refusal("time_s,address\n0.1,5", EventFormat::csv), "line 2: is cut off");
    EXPECT_EQ(refusal("time_s,address\n0.1,-5\n", EventFormat::csv),
              "line 2: address must be a whole number below 2^32");
    EXPECT_EQ(refusal("time_s,address\nnan,5\n", EventFormat::csv),
              "line 2: time_s must be seconds with at most nine decimals");
    EXPECT_EQ(refusal("time_s,address\n2,1\n1,1\n", EventFormat::csv), "event 2: time runs backwards");
    EXPECT_EQ(refusal("Event Strum", EventFormat::event_stream), "byte 0: not an Event Stream of version 2");
    EXPECT_NE(refusal({"Event Stream\x02\0\0\x01", 16}, EventFormat::event_stream), "accepted");
    EXPECT_NE(refusal({"Event Stream\x02\0\0\0\x05\x08\x01", 19}, EventFormat::event_stream), "accepted");
    EXPECT_EQ(refusal("#!AER-DAT2.0\r\n1234", EventFormat::aedat2), "byte 18: ends within an event");
    EXPECT_FALSE(write_events(std::vector<Event>{{at(72min), 1}}, EventFormat::aedat2));
    // Its first byte is a #, which begins a comment.
    EXPECT_FALSE(write_events(std::vector<Event>{{at(1ms), 0x23000000}}, EventFormat::aedat2));
    EXPECT_FALSE(write_events(std::vector<Event>{{at(24h * 365), 1}}, EventFormat::event_stream));
    EXPECT_FALSE(format_of("events.mat"));
}

TEST(EventFiles, SurviveAnyTruncationAndGarbage) {
    std::mt19937_64 random(2);
    for (const EventFormat format : {EventFormat::csv, EventFormat::event_stream, EventFormat::aedat2}) {
        const auto whole = value_or_throw(write_events(some_events(1us, 5000), format));
        for (int repeat = 0; repeat < 300; ++repeat) {
            auto changed = whole;
            changed.resize(random() % changed.size());
            for (int i = 0; i < 3 && !changed.empty(); ++i)
                changed[random() % changed.size()] = static_cast<std::byte>(random());
            const auto read = read_events(changed, format);
            EXPECT_TRUE(!read || std::is_sorted(read.value().begin(), read.value().end()));
        }
    }
}

}  // namespace
}  // namespace afferent
