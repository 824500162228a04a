// Live events, as another program reads them.
#include "afferent/nodes/live_events.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run.hpp"
#include "tests/nodes/two_nodes.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

// What jAER's unicast has: a number, then address and microseconds, 32 bits each, most significant byte
// first.
struct Reader {
    std::vector<std::uint32_t> numbers;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> events;  // address, microseconds
    std::size_t longest = 0;

    explicit Reader(const fs::path& path) : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
        sockaddr_un at{};
        at.sun_family = AF_UNIX;
        path.string().copy(at.sun_path, sizeof at.sun_path - 1);
        EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    }
    Reader() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
        socklen_t size = sizeof at;
        EXPECT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size), 0);
        port = ntohs(at.sin_port);
    }
    ~Reader() { ::close(socket_); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    void read() {
        std::array<unsigned char, 65536> bytes{};
        for (ssize_t size = 0; (size = ::recv(socket_, bytes.data(), bytes.size(), 0)) > 0;) {
            const auto number_at = [&](ssize_t at) {
                const unsigned char* of = bytes.data() + at;
                return std::uint32_t{of[0]} << 24 | std::uint32_t{of[1]} << 16 | std::uint32_t{of[2]} << 8 |
                       of[3];
            };
            ASSERT_EQ(size % 8, 4);
            longest = std::max(longest, static_cast<std::size_t>(size));
            numbers.push_back(number_at(0));
            for (ssize_t at = 4; at < size; at += 8) events.emplace_back(number_at(at), number_at(at + 4));
        }
    }

    std::uint16_t port = 0;

  private:
    int socket_;
};

std::vector<std::pair<std::uint32_t, std::uint32_t>> as_sent(const std::vector<Event>& events) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sent;
    for (const Event& event : events)
        sent.emplace_back(event.address,
                          static_cast<std::uint32_t>((event.time - scene_start).count() / 1000));
    return sent;
}

class LiveEventsTest : public testing::Test {
  protected:
    LiveEventsTest() {
        std::string name = (fs::temp_directory_path() / "afferent-live-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
    }
    ~LiveEventsTest() override { fs::remove_all(folder_); }

    std::string socket() const { return (folder_ / "events.sock").string(); }
    std::string to_socket() const { return "output { live_events { path: '" + socket() + "' } } "; }

    // Runs the scene, and returns what the hand's end of its link knows of the events.
    std::vector<Event> run(const std::string& text, Reader& reader, OutputLosses* lost = nullptr) {
        const Plan plan = make_plan(Scene::from_text(text));
        EXPECT_EQ(plan.controller.has_value(), text.find("controller") != std::string::npos);
        std::vector<Event> events;
        const auto run = value_or_throw(Run::open(plan, {.events = [&](std::span<const Event> some) {
                                                      events.insert(events.end(), some.begin(), some.end());
                                                  }}));
        if (text.find("record_it") != std::string::npos)
            value_or_throw(run->record(recording(), make_hello(plan, false)));
        while (!run->done()) {
            value_or_throw(run->do_next());
            reader.read();
        }
        run->finish(plan.end());
        reader.read();
        value_or_throw(run->close());
        if (lost) *lost = run->lost_by_outputs();
        return events;
    }

    std::string recording() const { return (folder_ / "r.afferent").string(); }

    fs::path folder_;
};

const std::string pressed_harder =
    "duration_s: 1 source { profile { point { time_s: 0 force_n: 2 } point { time_s: 1 force_n: 9 } } } "
    "record { force: false picture: false } ";

TEST_F(LiveEventsTest, ReachAUnixSocketWithoutADecoder) {
    Reader reader{fs::path(socket())};
    const std::vector<Event> events = run(pressed_harder + to_socket(), reader);
    ASSERT_GT(events.size(), 100U);
    EXPECT_EQ(reader.events, as_sent(events));
    for (std::size_t i = 0; i < reader.numbers.size(); ++i) EXPECT_EQ(reader.numbers[i], i);
}

TEST_F(LiveEventsTest, StandBesideCommandsInAFile) {
    Reader reader{fs::path(socket())};
    const std::string commands = (folder_ / "commands.csv").string();
    const Plan plan =
        make_plan(Scene::from_text("duration_s: 1 hand { user { close_at_s: 0.1 } object { distance_mm: 5 } "
                                   "} output { command_file { path: '" +
                                   commands + "' } } " + to_socket()));
    ASSERT_TRUE(plan.controller);
    const auto run = value_or_throw(Run::open(plan, {}));
    while (!run->done()) {
        value_or_throw(run->do_next());
        reader.read();
    }
    run->finish(plan.end());
    value_or_throw(run->close());
    EXPECT_GT(reader.events.size(), 10U);
    std::ifstream file(commands);
    EXPECT_EQ(std::count(std::istreambuf_iterator<char>(file), {}, '\n'), 1001);
}

// Behind packets the time of an event is the begin of its tick.
TEST_F(LiveEventsTest, ReachAPortAsTheHandsEndOfTheLinkKnowsThem) {
    Reader reader;
    std::vector<Event> events =
        run(pressed_harder + "link { tcp {} tick_us: 100 } output { live_events { port: " +
                std::to_string(reader.port) + " } }",
            reader);
    for (Event& event : events) event.time -= (event.time - scene_start) % 100us;
    ASSERT_GT(events.size(), 100U);
    EXPECT_EQ(reader.events, as_sent(events));
}

TEST_F(LiveEventsTest, AreLostAndCountedWhereNobodyListens) {
    Reader other;
    OutputLosses lost;
    const std::vector<Event> events = run(pressed_harder + to_socket(), other, &lost);
    EXPECT_GT(events.size(), 100U);
    EXPECT_EQ(lost.events, events.size());
    EXPECT_EQ(lost.steps, 0U);
}

// Of 300 events in one span 128 fit into a datagram.
TEST_F(LiveEventsTest, ComeInDatagramsOfBoundedLength) {
    Reader reader{fs::path(socket())};
    LiveEvents live = value_or_throw(LiveEvents::open(Scene(), {.path = socket()}));
    std::vector<Event> events(300);
    // The 2^32 microseconds of a stamp are over after 71 minutes.
    const TimePoint late = scene_start + std::chrono::microseconds(0x1'0000'0005);
    for (std::uint32_t i = 0; i < 300; ++i) events[i] = {late, 0x0102'0304U + i};
    live.observe({late, late + 1ms}, events);
    live.observe({late + 1ms, late + 2ms}, {});
    reader.read();
    EXPECT_EQ(reader.numbers, (std::vector<std::uint32_t>{0, 1, 2}));
    EXPECT_EQ(reader.longest, 4 + 8 * 128U);
    ASSERT_EQ(reader.events.size(), 300U);
    EXPECT_EQ(reader.events.front(), std::pair(0x0102'0304U, 5U));
    EXPECT_EQ(reader.events.back().first, 0x0102'0304U + 299);
    EXPECT_EQ(live.lost().events, 0U);
}

TEST_F(LiveEventsTest, DoNotLeaveTheMachine) {
    for (const char* host : {"192.0.2.7", "::", "0.0.0.0", "example.org"}) {
        const auto opened = LiveEvents::open(Scene(), {.host = host});
        ASSERT_FALSE(opened) << host;
        EXPECT_EQ(opened.error().kind, Error::Kind::not_allowed);
        EXPECT_NE(opened.error().text.find(host), std::string::npos) << opened.error().text;
    }
    EXPECT_TRUE(LiveEvents::open(Scene(), {.host = "localhost"}));
    EXPECT_TRUE(LiveEvents::open(Scene(), {.host = "::1"}));
    EXPECT_FALSE(LiveEvents::open(Scene(), {.path = std::string(200, 'x')}));
}

TEST_F(LiveEventsTest, ComeFromAHandAsPacketsDo) {
    Reader reader{fs::path(socket())};
    TwoNodes nodes(pressed_harder + "link { tcp {} } " + to_socket());
    nodes.start_hand();
    nodes.start_coprocessor();
    while (!nodes.hand.ended || !nodes.coprocessor.ended) {
        nodes.run_for(10ms);
        reader.read();
    }
    ASSERT_GT(nodes.hand.events.size(), 100U);
    EXPECT_EQ(reader.events, as_sent(nodes.hand.events));
    EXPECT_EQ(nodes.hand.node->report().lost_events, 0U);
}

// What a recording's own scene says is not opened: it may be somebody else's.
TEST_F(LiveEventsTest, ComeFromAReplayThatAsksForThem) {
    Reader reader{fs::path(socket())};
    run(pressed_harder + "# record_it\n link { tcp {} } " + to_socket(), reader);
    const auto sent = reader.events;
    ASSERT_GT(sent.size(), 100U);
    const auto replay = [&](const Scene* outputs) {
        reader.events.clear();
        const auto opened = value_or_throw(Replay::open(recording(), {}, {}, outputs));
        while (value_or_throw(opened->next())) {
            opened->step();
            reader.read();
        }
        reader.read();
        value_or_throw(opened->close());
    };
    replay(nullptr);
    EXPECT_TRUE(reader.events.empty());
    const Scene asked = Scene::from_text(to_socket());
    replay(&asked);
    EXPECT_EQ(reader.events, sent);
}

}  // namespace
}  // namespace afferent
