// Peers that connect and are not the right one, over every transport that is a stream.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <filesystem>
#include <fstream>
#include <thread>

#include "afferent/io/links/certificate.hpp"
#include "afferent/io/links/key_folder.hpp"
#include "afferent/io/links/rate_limit.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/io/links/waiting_line.hpp"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/memory_in_use.hpp"
#include "tests/io/links/run_until.hpp"
#include "tests/io/links/transport_name.hpp"
#include "tests/io/links/turn_clock.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using std::chrono::milliseconds;

class OneHand final : public HandClient {
  public:
    void welcomed(const proto::Hello&) override { ++welcomes; }
    void received(const Reception&) override { ++packets; }
    void clock(TimePoint) override { ++clocks; }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd& end) override {
        ends.push_back(end);
        link = session->counts();
        session.reset();
    }

    std::unique_ptr<HandSession> session;
    int welcomes = 0;
    int packets = 0;
    int clocks = 0;
    std::vector<SessionEnd> ends;
    LinkCounts link;
};

class OneCoprocessor final : public CoprocessorClient {
  public:
    void welcomed() override { ++welcomes; }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd& end) override {
        ends.push_back(end);
        link = session->counts();
        session.reset();
    }
    void send_packet() {
        proto::Envelope packet;
        packet.set_position(++position + 1);
        packet.set_spans(1);
        session->send_packet(packet);
    }

    std::unique_ptr<Connector> connector;
    std::unique_ptr<CoprocessorSession> session;
    std::uint32_t position = 0;
    int welcomes = 0;
    std::vector<SessionEnd> ends;
    LinkCounts link;
};

class Strangers : public testing::TestWithParam<const char*> {
  protected:
    Strangers() {
        std::string name = (std::filesystem::temp_directory_path() / "afferent-strangers-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        if (transport() == "tls") {
            for (const LinkEnd link_end : {LinkEnd::coprocessor, LinkEnd::hand})
                EXPECT_TRUE(
                    write_certificate("test", keys().certificate(link_end), keys().private_key(link_end)));
        }
    }
    ~Strangers() override { std::filesystem::remove_all(folder_); }

    static std::string transport() { return GetParam(); }
    KeyFolder keys() const { return {folder_}; }

    void listen(milliseconds alive_limit = milliseconds(10'000)) {
        const LinkAddress address = [&]() -> LinkAddress {
            if (transport() == "unix") return UnixAddress{folder_ / "hand.sock"};
            if (transport() == "tcp") return TcpAddress{"127.0.0.1", 0};
            return TlsAddress{"127.0.0.1", 0, keys().credentials(LinkEnd::hand)};
        }();
        auto opened = open_listener(io_, address, {.alive_limit = alive_limit});
        ASSERT_TRUE(opened) << opened.error().text;
        listener_ = std::move(opened).value();
        listener_->start([this](std::unique_ptr<Link> link) {
            hand_.session = std::make_unique<HandSession>(std::move(link), hello_of_nine(), hand_, limits_,
                                                          time_.reader());
            hand_.session->start();
        });
    }

    LinkAddress address() const {
        LinkAddress address = listener_->address();
        if (auto* const tls = std::get_if<TlsAddress>(&address))
            tls->credentials = keys().credentials(LinkEnd::coprocessor);
        return address;
    }

    void connect(OneCoprocessor& coprocessor) {
        coprocessor.connector = make_connector(io_, address());
        coprocessor.connector->start([this, &coprocessor](Result<std::unique_ptr<Link>> link) {
            ASSERT_TRUE(link) << link.error().text;
            coprocessor.session = std::make_unique<CoprocessorSession>(
                std::move(link).value(), hello_of_nine(), coprocessor, limits_, time_.reader());
            coprocessor.session->start();
        });
    }

    // A connection that sends nothing by itself.
    template <class Socket>
    Socket raw_peer() {
        Socket socket(io_);
        if constexpr (std::is_same_v<Socket, asio::ip::tcp::socket>) {
            const std::uint16_t port = transport() == "tcp" ? std::get<TcpAddress>(listener_->address()).port
                                                            : std::get<TlsAddress>(listener_->address()).port;
            socket.connect({asio::ip::make_address("127.0.0.1"), port});
        } else {
            socket.connect(std::get<UnixAddress>(listener_->address()).path);
        }
        socket.non_blocking(true);
        return socket;
    }
    template <class Use>
    void with_raw_peers(Use use) {
        if (transport() == "unix")
            use([this] { return raw_peer<asio::local::stream_protocol::socket>(); });
        else
            use([this] { return raw_peer<asio::ip::tcp::socket>(); });
    }

    template <class Condition>
    void run_until(Condition condition) {
        afferent::run_until(io_, condition, [this] {
            time_.turn();
            if (hand_.session) hand_.session->poll();
            if (first_.session) first_.session->poll();
            if (second_.session) second_.session->poll();
        });
    }

    // Reads until the other end closes, as a frame, or something else.
    template <class Socket>
    std::string what_is_answered(Socket& socket) {
        std::array<char, 4096> space;
        std::string text;
        run_until([&] {
            boost::system::error_code error;
            const std::size_t count = socket.receive(asio::buffer(space), 0, error);
            text.append(space.data(), count);
            return error && error != asio::error::would_block;
        });
        return text;
    }

    std::filesystem::path folder_;
    asio::io_context io_;
    TurnClock time_{20ms};
    SessionLimits limits_{.silence = milliseconds(0)};
    OneHand hand_;
    OneCoprocessor first_;
    OneCoprocessor second_;
    std::unique_ptr<Listener> listener_;
};

INSTANTIATE_TEST_SUITE_P(Transports, Strangers, testing::Values("unix", "tcp", "tls"), transport_name);

// Transports that have many peers at once.
class SocketStrangers : public Strangers {};
INSTANTIATE_TEST_SUITE_P(Transports, SocketStrangers, testing::Values("unix", "tcp", "tls"), transport_name);

// Transports on which anybody can write a frame.
class PlainStrangers : public Strangers {};
INSTANTIATE_TEST_SUITE_P(Transports, PlainStrangers, testing::Values("unix", "tcp"), transport_name);

std::vector<std::byte> frame_of(const proto::Envelope& message) {
    FrameWriter writer;
    const auto frame = writer.stream_frame(message);
    return {frame.begin(), frame.end()};
}

TEST_P(SocketStrangers, WhoSayNothingKeepNobodyOut) {
    listen();
    with_raw_peers([&](auto connect_raw) {
        std::vector<decltype(connect_raw())> idle;
        for (int i = 0; i < 5; ++i) idle.push_back(connect_raw());
        connect(first_);
        run_until([&] { return first_.welcomes == 1; });
        // None of them disturbs a session, and their time is limited.
        for (int i = 0; i < 5; ++i) idle.push_back(connect_raw());
        auto due = std::chrono::steady_clock::now();
        run_until([&] {
            if (const auto now = std::chrono::steady_clock::now(); now >= due) {
                first_.send_packet();
                due = now + milliseconds(50);
            }
            return listener_->refused_peers() == 10;
        });
    });
    EXPECT_TRUE(hand_.ends.empty()) << hand_.ends.at(0).reason;
    EXPECT_GT(hand_.packets, 0);
}

TEST_P(SocketStrangers, InHundredsTakeLittleMemory) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer has an allocator of its own";
#endif
    constexpr std::size_t many = 700;
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, many + 1000);
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
    if (limit.rlim_cur < many + 500) GTEST_SKIP() << "too few descriptors";
    listen();
    connect(first_);
    run_until([&] { return first_.welcomes == 1; });
    const std::size_t before = bytes_in_use();
    std::size_t most = before;
    with_raw_peers([&](auto connect_raw) {
        std::vector<decltype(connect_raw())> idle;
        idle.reserve(many);
        while (idle.size() < many) {
            // As many as the system's queue takes at once, and as the listener lets go.
            for (int i = 0; i < 50 && idle.size() < many; ++i) idle.push_back(connect_raw());
            const std::uint64_t refused = listener_->refused_peers();
            if (idle.size() > WaitingLine::most)
                run_until([&] { return listener_->refused_peers() > refused; });
            first_.send_packet();
            most = std::max(most, bytes_in_use());
        }
        run_until([&] { return listener_->refused_peers() >= many - WaitingLine::most; });
        first_.send_packet();
        run_until([&] { return hand_.packets == static_cast<int>(first_.position); });
    });
    // The test's own ends among it.
    EXPECT_LT(most - before, many * 4096);
    EXPECT_TRUE(hand_.ends.empty());
}

TEST_P(PlainStrangers, WhoBeginWithAnythingButAHelloAreRefused) {
    listen();
    proto::Envelope bye;
    bye.mutable_bye()->set_reason(proto::END_OF_SCENE);
    proto::Envelope packet;
    packet.set_position(1);
    std::vector<std::byte> garbage(200, std::byte{'x'});
    with_raw_peers([&](auto connect_raw) {
        const std::vector<std::pair<std::vector<std::byte>, std::string>> beginnings{
            {frame_of(bye), "the first message is not a hello"},
            {frame_of(packet), "the first message is not a hello"},
            {garbage, "fails its checksum"}};
        for (const auto& [bytes, answer] : beginnings) {
            auto socket = connect_raw();
            asio::write(socket, asio::buffer(bytes.data(), bytes.size()));
            EXPECT_NE(what_is_answered(socket).find(answer), std::string::npos) << answer;
        }
    });
    EXPECT_EQ(listener_->refused_peers(), 3U);
    EXPECT_EQ(hand_.welcomes, 0);
    EXPECT_TRUE(hand_.ends.empty()) << "none of them had a session";
    connect(first_);
    run_until([&] { return first_.welcomes == 1; });
}

TEST_P(Strangers, WhoCannotShowThemselvesMayTryAgainWhileTheFirstIsAlive) {
    listen();
    connect(first_);
    run_until([&] { return first_.welcomes == 1; });
    connect(second_);
    run_until([&] { return !second_.ends.empty(); });
    EXPECT_EQ(second_.ends.at(0).reason, "the hand refuses: another coprocessor is connected");
    EXPECT_TRUE(second_.ends.at(0).unanswered) << "a later attempt may succeed";
    EXPECT_EQ(hand_.welcomes, 1);
}

// The first peer goes without a word: its process is stopped, or its cable is cut.
TEST_P(Strangers, TakeThePlaceOfOneThatIsSilentForTooLong) {
    listen(milliseconds(100));
    connect(first_);
    run_until([&] { return first_.welcomes == 1; });
    std::this_thread::sleep_for(milliseconds(120));
    connect(second_);
    run_until([&] { return second_.welcomes == 1 && !first_.ends.empty(); });
    ASSERT_EQ(hand_.ends.size(), 1U);
    EXPECT_FALSE(hand_.ends.at(0).complete);
    EXPECT_NE(hand_.ends.at(0).reason.find("another has taken its place"), std::string::npos)
        << hand_.ends.at(0).reason;
    EXPECT_EQ(hand_.welcomes, 2);
}

// One end counts as sent what the other counts as received, to the byte, and with TLS both count what the
// socket carries.
TEST_P(Strangers, AreNotNeededForBothSidesToCountTheSameBytes) {
    listen();
    connect(first_);
    run_until([&] { return first_.welcomes == 1; });
    for (int i = 0; i < 3000; ++i) {
        first_.send_packet();
        if (i % 100 == 0) hand_.session->send_status({});
    }
    proto::Bye bye;
    bye.set_packets(3000);
    first_.session->say_bye(bye);
    run_until([&] { return !first_.ends.empty() && !hand_.ends.empty(); });
    EXPECT_TRUE(first_.ends.at(0).complete);
    EXPECT_EQ(first_.link.dropped, 0U);
    EXPECT_EQ(first_.link.bytes_out, hand_.link.in.bytes);
    EXPECT_EQ(hand_.link.bytes_out, first_.link.in.bytes);
    EXPECT_GT(hand_.link.bytes_out, 30U);
    if (transport() == "tls") {
        EXPECT_GT(hand_.link.bytes_out, 500U) << "certificate and all";
    }
}

TEST_P(PlainStrangers, WhoFloodASessionLeaveTheLoopToOthersAndLoseIt) {
    listen();
    std::vector<std::byte> flood = frame_of(hello_message());
    proto::Envelope clock;
    clock.mutable_clock()->set_time_ns(1);
    const std::vector<std::byte> frame = frame_of(clock);
    for (int i = 0; i < 2000; ++i) flood.insert(flood.end(), frame.begin(), frame.end());
    for (const std::uint32_t most : {0U, 200U}) {
        limits_.messages = most;
        hand_.clocks = 0;
        with_raw_peers([&](auto connect_raw) {
            auto socket = connect_raw();
            asio::write(socket, asio::buffer(flood.data(), flood.size()));
            int most_at_once = 0;
            while (hand_.clocks < 2000 && hand_.ends.empty()) {
                const int before = hand_.clocks;
                io_.restart();
                ASSERT_GT(io_.run_one_for(std::chrono::seconds(10)), 0U);
                most_at_once = std::max(most_at_once, hand_.clocks - before);
            }
            EXPECT_GT(most_at_once, 0);
            EXPECT_LE(most_at_once, 64);
        });
        if (most == 0) {
            run_until([&] { return !hand_.session; });
            hand_.ends.clear();
        }
    }
    EXPECT_LE(hand_.clocks, 200);
    EXPECT_NE(hand_.ends.at(0).reason.find("more messages than a session has"), std::string::npos)
        << hand_.ends.at(0).reason;
}

TEST_P(SocketStrangers, WhoConnectInHundredsAreAcceptedAFewAtATime) {
    listen();
    with_raw_peers([&](auto connect_raw) {
        std::vector<decltype(connect_raw())> crowd;
        for (int i = 0; i < 100; ++i) crowd.push_back(connect_raw());
        io_.restart();
        const auto began = std::chrono::steady_clock::now();
        std::size_t handlers = io_.poll();
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
        EXPECT_LE(static_cast<double>(handlers), 60 + 5000 * seconds);
    });
}

TEST(SocketFile, IsRemovedByItsOwnerAlone) {
    asio::io_context io;
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("afferent-own-" + std::to_string(getpid()));
    auto first = open_listener(io, UnixAddress{path});
    ASSERT_TRUE(first);
    // The file was removed, and another hand has started since.
    std::filesystem::remove(path);
    auto second = open_listener(io, UnixAddress{path});
    ASSERT_TRUE(second);
    first.value().reset();
    EXPECT_TRUE(std::filesystem::exists(path));
    second.value().reset();
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(RateLimit, AllowsSoManyAtOnceAndSoManyASecond) {
    RateLimit limit(100, 5);
    RateLimit::Time now{std::chrono::hours(1)};
    const RateLimit::Time end = now + std::chrono::seconds(10);
    int at_once = 0;
    while (limit.take(now).count() == 0) ++at_once;
    EXPECT_EQ(at_once, 5);
    int taken = 0;
    while (now < end) {
        const auto wait = limit.take(now);
        if (wait.count() == 0) ++taken;
        now += wait;
    }
    EXPECT_EQ(taken, 999);
}

TEST(WaitingLine, TurnsAwayTheOldestOfTooManyAndWhoeverHasWaitedForTooLong) {
    asio::io_context io;
    const auto line = std::make_shared<WaitingLine>(io, 10, milliseconds(20));
    std::vector<std::size_t> turned_away;
    std::vector<WaitingLine::Place> places;
    for (std::size_t i = 0; i <= 10; ++i)
        places.push_back(line->enter([&turned_away, i] { turned_away.push_back(i); }));
    EXPECT_EQ(turned_away, std::vector<std::size_t>{0});
    for (std::size_t i = 3; i < places.size(); ++i) line->leave(places[i]);
    run_until(
        io, [&] { return turned_away.size() == 3; }, [] {});
    EXPECT_EQ(turned_away, (std::vector<std::size_t>{0, 1, 2}));
    line->enter([&turned_away] { turned_away.push_back(100); });
    line->close();
    EXPECT_EQ(turned_away.back(), 100U);
}

// Its timer's callback can no longer be called off then.
TEST(WaitingLine, MayGoWhenSomebodysTimeIsUp) {
    asio::io_context io;
    auto line = std::make_shared<WaitingLine>(io, 10, milliseconds(0));
    line->enter([] { ADD_FAILURE() << "the line is gone"; });
    asio::steady_timer due_before(io, std::chrono::steady_clock::time_point{});
    due_before.async_wait([&](const boost::system::error_code&) { line.reset(); });
    io.run();
    EXPECT_FALSE(line);
}

}  // namespace
}  // namespace afferent
