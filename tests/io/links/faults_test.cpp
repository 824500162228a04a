// Sessions over bad links: over every transport, through a relay that makes the faults.
#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/write.hpp>
#include <deque>
#include <filesystem>
#include <random>
#include <stdexcept>

#include "afferent/io/links/relay.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/runtime/grip_guard.hpp"
#include "bench/short_lived_keys.hpp"
#include "tests/io/links/turn_clock.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr PacketLayout layout{.addresses = 9};

constexpr Duration usual_turn = 2ms;

// Everything that a decoder would be told, and the resulting counts.
class Hand final : public HandClient {
    const TurnClock& time_;

  public:
    explicit Hand(const TurnClock& time) : time_(time) {}

    void welcomed(const proto::Hello& hello) override {
        nonces.push_back(hello.nonce());
        guard.session_opened(time_.now());
        // What was decoded before is no longer valid.
        told = start;
        events.clear();
        unknown = Duration::zero();
    }
    void received(const Reception& reception) override {
        if (reception.measured()) guard.heard(heard = time_.now());
        if (reception.gap) {
            // Gaps and known spans follow each other without a hole; a part of a packet may be reported lost
            // once the rest of it is known.
            EXPECT_LE(reception.gap->begin, told);
            EXPECT_GE(reception.gap->end, told);
            unknown += reception.gap->end - reception.gap->begin;
            told = reception.gap->end;
        }
        EXPECT_EQ(reception.known.begin, told);
        told = reception.known.end;
        events.insert(events.end(), reception.events.begin(), reception.events.end());
    }
    std::optional<TimePoint> scene_time() const override {
        return clock ? std::optional(clock()) : std::nullopt;
    }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd& end) override {
        guard.session_ended(time_.now());
        ends.push_back(end);
        counts = session->receiver_counts();
        link = session->counts();
        refused = session->refused_messages();
        session.reset();
    }

    GripState grip_state() { return guard.state(time_.now()); }

    GripGuard guard{{.freeze = 60ms, .safe = 150ms}, time_.now()};
    MonotonicTime heard{};
    TimePoint start = scene_start;
    std::function<TimePoint()> clock;
    std::unique_ptr<HandSession> session;
    std::vector<std::uint64_t> nonces;
    std::vector<Event> events;
    TimePoint told = scene_start;
    Duration unknown{};
    std::vector<SessionEnd> ends;
    PacketCounts counts;
    LinkCounts link;
    std::uint64_t refused = 0;
};

// Sends packets of random events, each at its deadline.
class Coprocessor final : public CoprocessorClient {
    const TurnClock& time_;

  public:
    explicit Coprocessor(const TurnClock& time) : time_(time) {}

    void welcomed() override {
        ++welcomes;
        packetizer.emplace(layout);
        if (start > scene_start) packetizer->begin_at(start);
        sent.clear();
        deadline = start + layout.span;
        began = time_.now();
    }
    std::optional<TimePoint> scene_time() const override { return now(); }
    proto::Bye answer_bye(const proto::Bye&) override { return bye(); }
    void ended(const SessionEnd& end) override {
        ends.push_back(end);
        link = session->counts();
        session.reset();
    }

    TimePoint now() const { return start + (time_.now() - began); }
    bool open() const { return session && session->state() == Session::State::open; }

    void send_what_is_due() {
        while (open() && !held && now() >= deadline) {
            std::vector<Event> events(random() % 5);
            // On the begin of their ticks, so that they come back as they are.
            for (Event& event : events)
                event = {deadline - layout.span + random() % (layout.span / layout.tick) * layout.tick,
                         static_cast<Address>(random() % layout.addresses)};
            std::sort(events.begin(), events.end());
            packetizer->push(events);
            sent.insert(sent.end(), events.begin(), events.end());
            packetizer->close(deadline, [&](const proto::Envelope& packet) {
                if (open() && !session->send_packet(packet)) packetizer->announce();
            });
            deadline += layout.span;
        }
    }

    proto::Bye bye() const {
        proto::Bye bye;
        bye.set_time_ns((deadline - layout.span - scene_start).count());
        bye.set_packets(packetizer->packets());
        bye.set_events(packetizer->events());
        return bye;
    }
    void finish() {
        packetizer->finish(deadline - layout.span,
                           [&](const proto::Envelope& packet) { session->send_packet(packet); });
        session->say_bye(bye());
    }

    TimePoint start = scene_start;
    bool held = false;
    std::unique_ptr<CoprocessorSession> session;
    std::optional<Packetizer> packetizer;
    std::vector<Event> sent;
    TimePoint deadline;
    MonotonicTime began;
    std::mt19937_64 random{1};
    int welcomes = 0;
    std::vector<SessionEnd> ends;
    LinkCounts link;
};

class Faults : public testing::TestWithParam<const char*> {
  protected:
    Faults() {
        std::string name = (std::filesystem::temp_directory_path() / "afferent-faults-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
        hand_.clock = [this] { return coprocessor_.now(); };
    }
    ~Faults() override { std::filesystem::remove_all(folder_); }

    static std::string transport() { return GetParam(); }
    static bool stream() { return transport() == "unix" || transport() == "tcp" || transport() == "tls"; }
    // Changed datagrams are recognised by a key, and not by a checksum.
    static bool sealed() {
        return transport() == "tls" || transport() == "udp_sealed" || transport() == "serial";
    }

    LinkAddress address(LinkEnd link_end) const {
        if (transport() == "unix") return UnixAddress{folder_ / "hand.sock"};
        if (transport() == "tcp") return TcpAddress{"127.0.0.1", 0};
        if (transport() == "tls") return TlsAddress{"127.0.0.1", 0, keys_.credentials(link_end)};
        if (transport() == "udp") return UdpAddress{"127.0.0.1", 0, std::nullopt};
        if (transport() == "udp_sealed") return UdpAddress{"127.0.0.1", 0, keys_.credentials(link_end)};
        return SerialAddress{folder_ / "tty", 921'600, keys_.credentials(link_end)};
    }

    // A serial line has to be there before somebody listens on it.
    void open(const ChannelParameters& to_hand) {
        RelayParameters parameters;
        parameters.to_hand = to_hand;
        parameters.to_coprocessor.latency = to_hand.latency;
        if (transport() != "serial") listen();
        LinkAddress from = address(LinkEnd::coprocessor);
        if (auto* const unix_address = std::get_if<UnixAddress>(&from)) unix_address->path += ".channel";
        if (auto* const serial = std::get_if<SerialAddress>(&from)) serial->device += ".channel";
        auto relay =
            Relay::open(io_, from, listener_ ? listener_->address() : address(LinkEnd::hand), parameters);
        ASSERT_TRUE(relay) << relay.error().text;
        relay_ = std::move(relay).value();
        if (transport() == "serial") listen();
        // With the port that was found, and the credentials of our own.
        way_ = relay_->address();
        if (auto* const tls = std::get_if<TlsAddress>(&way_))
            tls->credentials = keys_.credentials(LinkEnd::coprocessor);
        if (auto* const udp = std::get_if<UdpAddress>(&way_)) {
            if (sealed()) udp->credentials = keys_.credentials(LinkEnd::coprocessor);
        }
    }

    void listen() {
        auto opened = open_listener(io_, address(LinkEnd::hand), options_);
        ASSERT_TRUE(opened) << opened.error().text;
        listener_ = std::move(opened).value();
        listener_->start([this](std::unique_ptr<Link> link) {
            hand_.start = coprocessor_.start;
            hand_.session =
                std::make_unique<HandSession>(std::move(link), hello(0), hand_, limits_, time_.reader());
            hand_.session->start();
        });
    }

    proto::Hello hello(std::uint64_t nonce) const {
        proto::Hello hello;
        describe(layout, hello);
        hello.set_scene_fingerprint(0x1234);
        hello.set_freeze_ms(60);
        hello.set_safe_ms(150);
        hello.set_stale_ms(stale_ms_);
        hello.set_nonce(nonce);
        return hello;
    }

    // As the program does it: until a session is open.
    void connect(const proto::Hello& hello) {
        unreached_.clear();
        connector_ = make_connector(io_, way_, {}, options_);
        connector_->start([this, hello](Result<std::unique_ptr<Link>> link) {
            if (!link) return void(unreached_ = link.error().text);
            SessionLimits limits = limits_;
            limits.handshake = milliseconds(500);
            coprocessor_.session = std::make_unique<CoprocessorSession>(std::move(link).value(), hello,
                                                                        coprocessor_, limits, time_.reader());
            coprocessor_.session->start();
        });
    }
    void connect_until_welcome() {
        const int before = coprocessor_.welcomes;
        for (int attempt = 0; attempt < 20 && coprocessor_.welcomes == before; ++attempt) {
            const std::size_t ends = coprocessor_.ends.size();
            connect(hello(++nonce_));
            run_until([&] {
                return coprocessor_.welcomes > before || coprocessor_.ends.size() > ends ||
                       !unreached_.empty();
            });
        }
        ASSERT_GT(coprocessor_.welcomes, before);
    }

    // Packets are stale to the hand until it has heard of the coprocessor's clock, so none becomes due
    // before.
    void wait_for_echo(Duration turn = Duration::zero()) {
        time_.longest_turn = turn;
        run_until([&] { return hand_.session && hand_.session->peer_clock().known(); });
        time_.longest_turn = usual_turn;
    }

    template <class Condition>
    void run_until(Condition condition, milliseconds limit = milliseconds(60'000)) {
        const auto end = Clock::now() + limit;
        while (!condition()) {
            if (Clock::now() > end) throw std::runtime_error("waited in vain");
            turn();
        }
    }
    void run_for(milliseconds time) {
        const auto end = time_.now() + time;
        while (time_.now() < end) turn();
    }
    void turn() {
        time_.turn();
        io_.restart();
        io_.run_one_for(milliseconds(1));
        io_.poll();
        if (hand_.session) hand_.session->poll();
        if (coprocessor_.session) coprocessor_.session->poll();
        coprocessor_.send_what_is_due();
        // Back from the hand, as it does, so that a cut is seen from both ends.
        if (time_.now() - told_ > milliseconds(50) && hand_.session &&
            hand_.session->state() == Session::State::open) {
            told_ = time_.now();
            hand_.session->send_status({});
        }
    }

    // Both ends say bye. On a bad link byes may be lost, and the counts are the last known.
    void finish() {
        hand_.ends.clear();
        coprocessor_.ends.clear();
        coprocessor_.finish();
        run_until([&] { return coprocessor_.ends.size() > 0 && hand_.ends.size() > 0; });
    }

    // Every event is delivered, in a gap that was reported, or of a packet that was told to be lost.
    void expect_accounted() {
        const std::vector<Event>& sent = coprocessor_.sent;
        EXPECT_TRUE(std::includes(sent.begin(), sent.end(), hand_.events.begin(), hand_.events.end()));
        EXPECT_EQ(hand_.counts.events, hand_.events.size());
        EXPECT_EQ(hand_.counts.events + hand_.counts.lost_events, sent.size());
        EXPECT_EQ(hand_.told, coprocessor_.deadline - layout.span);
        if (hand_.counts.lost_events > 0) {
            EXPECT_GT(hand_.unknown, Duration::zero());
        }
    }

    std::filesystem::path folder_;
    ShortLivedKeys keys_;
    asio::io_context io_;
    TurnClock time_{usual_turn};
    // Links keep to the wall clock, and a silent one is not the subject of most tests; nor is a late bye.
    LinkOptions options_{.silence_limit = milliseconds(10'000)};
    SessionLimits limits_{.farewell = milliseconds(5000), .silence = milliseconds(10'000)};
    Hand hand_{time_};
    Coprocessor coprocessor_{time_};
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<Relay> relay_;
    LinkAddress way_;
    std::unique_ptr<Connector> connector_;
    std::string unreached_;
    std::uint64_t nonce_ = 0;
    std::uint32_t stale_ms_ = 100;
    MonotonicTime told_{};
};

INSTANTIATE_TEST_SUITE_P(Transports, Faults,
                         testing::Values("unix", "tcp", "tls", "udp", "udp_sealed", "serial"),
                         [](const auto& transport) { return std::string(transport.param); });

TEST_P(Faults, NoneAtAll) {
    stale_ms_ = 10'000;  // the kernel may be late with what a terminal is given
    open({});
    connect_until_welcome();
    wait_for_echo();
    run_for(milliseconds(300));
    finish();
    EXPECT_EQ(hand_.events, coprocessor_.sent);
    EXPECT_EQ(hand_.unknown, Duration::zero());
    EXPECT_EQ(hand_.counts.stale, 0U);
    EXPECT_EQ(coprocessor_.link.dropped, 0U);
    EXPECT_EQ(hand_.link.in.forged, 0U);
    EXPECT_TRUE(hand_.ends.at(0).complete);
    expect_accounted();
}

// Whole frames are lost: the decoder knows when nothing is known, and nothing is sent again. TLS does not
// survive the loss of a byte: its session ends, and says so.
TEST_P(Faults, LostPacketsLeaveAKnownGap) {
    limits_.farewell = milliseconds(500);  // the bye may be lost
    open({.loss = 0.2});
    connect_until_welcome();
    if (transport() == "tls") {
        run_until([&] { return !hand_.ends.empty(); });
        EXPECT_FALSE(hand_.ends.at(0).complete);
        return;
    }
    run_for(milliseconds(600));
    const std::uint64_t packets = coprocessor_.packetizer->packets();
    finish();
    EXPECT_GT(hand_.counts.gaps, 5U);
    EXPECT_LT(hand_.counts.packets, packets);
    EXPECT_EQ(hand_.counts.out_of_order, 0U);
    if (hand_.ends.at(0).complete) expect_accounted();
}

TEST_P(Faults, SilenceFreezesAndThenMakesSafeUntilANewHello) {
    open({});
    connect_until_welcome();
    run_until([&] { return hand_.grip_state() == GripState::operating && hand_.heard == time_.now(); });
    relay_->pull(true);
    const auto pulled = time_.now();
    run_until([&] { return hand_.grip_state() == GripState::frozen; });
    EXPECT_GE(time_.now() - pulled, milliseconds(60));
    run_until([&] { return hand_.grip_state() == GripState::safe; });
    EXPECT_GE(time_.now() - pulled, milliseconds(150));
    // Packets come again, and change nothing.
    relay_->pull(false);
    const std::uint64_t before = hand_.session->receiver_counts().packets;
    run_until([&] { return !hand_.session || hand_.session->receiver_counts().packets > before + 5; });
    EXPECT_EQ(hand_.grip_state(), GripState::safe);
    // Only a new session ends that.
    if (coprocessor_.session) coprocessor_.session.reset();
    if (stream()) run_until([&] { return !hand_.session; });
    const std::size_t sessions = hand_.nonces.size();
    connect_until_welcome();
    run_until([&] { return hand_.nonces.size() == sessions + 1 && hand_.session; });
    EXPECT_EQ(hand_.grip_state(), GripState::safe) << "before its packets have arrived";
    run_until([&] { return hand_.grip_state() == GripState::operating; });
    EXPECT_NE(hand_.nonces[sessions - 1], hand_.nonces[sessions]);
}

// In datagrams, such packets are dropped and counted; on a stream they cannot occur, and the session ends.
TEST_P(Faults, DuplicateAndReorderedPacketsAreDroppedOrEndAStream) {
    time_.keep_wall_time();  // as the delays of the relay do
    open({.latency = 8ms, .jitter = 4ms, .reorder = 0.2, .duplicate = 0.2});
    if (stream()) {
        connect(hello(++nonce_));
        // TLS may not even come to a session.
        run_until([&] { return !hand_.ends.empty() || listener_->refused_peers() > 0; });
        for (const SessionEnd& end : hand_.ends) {
            EXPECT_FALSE(end.complete);
            EXPECT_FALSE(end.reason.empty());
        }
        return;
    }
    connect_until_welcome();
    run_for(milliseconds(1000));
    ASSERT_TRUE(hand_.session);
    const std::uint64_t dropped =
        hand_.session->receiver_counts().out_of_order + hand_.session->counts().in.repeated;
    EXPECT_GT(dropped, 20U);
    finish();
    EXPECT_GT(hand_.counts.gaps, 0U);  // what was overtaken
    expect_accounted();
}

TEST_P(Faults, ChangedFramesAreDroppedAndCounted) {
    open({.corrupt = 0.02});
    connect_until_welcome();
    const auto bad = [&] {
        const FrameCounts& in = hand_.session ? hand_.session->counts().in : hand_.link.in;
        return in.checksum_failures + in.refused + in.forged;
    };
    // TLS ends with the first.
    run_until([&] { return transport() == "tls" ? !hand_.ends.empty() : bad() >= 3; });
    for (const SessionEnd& end : hand_.ends) EXPECT_FALSE(end.reason.empty());
    // Where a length was changed a stream cannot be followed; nothing ends a datagram session.
    if (!stream()) {
        EXPECT_TRUE(hand_.ends.empty());
    }
    for (const Event& event : hand_.events)
        EXPECT_TRUE(std::binary_search(coprocessor_.sent.begin(), coprocessor_.sent.end(), event));
}

TEST_P(Faults, WhereEveryFrameIsChangedThereIsNoSession) {
    open({.corrupt = 1});
    connect(hello(++nonce_));
    if (transport() == "unix" || transport() == "tcp") {
        run_until([&] { return listener_->refused_peers() == 1; });
    } else {
        run_for(milliseconds(700));
    }
    EXPECT_EQ(coprocessor_.welcomes, 0);
    EXPECT_TRUE(hand_.nonces.empty());
}

TEST_P(Faults, ANarrowWayDropsTheOldestAndNeverBlocks) {
    time_.keep_wall_time();  // as the delays of the relay do
    // A part of what the packets need, and enough for a handshake.
    open({.bandwidth_bps = sealed() ? 24e3 : 8e3});
    connect_until_welcome();
    const auto began = Clock::now();
    int turns = 0;
    int long_turns = 0;
    while (Clock::now() - began < milliseconds(700) || turns < 200) {
        const auto before = Clock::now();
        coprocessor_.send_what_is_due();
        if (Clock::now() - before > milliseconds(100)) ++long_turns;
        turn();
        ++turns;
    }
    // Any turn may be held up by other programs. A link that waits for room would do so again and again.
    EXPECT_LT(long_turns, 10);
    // The packets were too old and were not used: the hand is safe, not led by the past.
    if (hand_.session) {
        EXPECT_GT(hand_.session->receiver_counts().stale, 0U);
        EXPECT_EQ(hand_.grip_state(), GripState::safe);
    }
}

TEST_P(Faults, StalePacketsAreRefusedByAgeAndAreNoSignOfLife) {
    time_.keep_wall_time();  // as the delays of the relay do
    open({.latency = 150ms});
    connect_until_welcome();
    run_until([&] { return !hand_.session || hand_.session->receiver_counts().stale >= 10; });
    ASSERT_TRUE(hand_.session);
    EXPECT_TRUE(hand_.events.empty());
    EXPECT_EQ(hand_.grip_state(), GripState::safe);
    finish();
    EXPECT_EQ(hand_.counts.events, 0U);
    EXPECT_EQ(hand_.counts.lost_events, coprocessor_.sent.size());
    EXPECT_EQ(hand_.unknown, coprocessor_.deadline - layout.span - scene_start);
}

TEST_P(Faults, AHalfOpenPeerIsSeenFromBothEndsAndAnewOneIsLetIn) {
    options_.silence_limit = milliseconds(1500);
    limits_.silence = milliseconds(1000);
    open({});
    connect_until_welcome();
    run_for(milliseconds(50));
    relay_->pull(true);
    const auto pulled = time_.now();
    run_until([&] { return !hand_.session && !coprocessor_.session; });
    EXPECT_LT(time_.now() - pulled, milliseconds(3500));
    EXPECT_FALSE(hand_.ends.at(0).complete);
    EXPECT_FALSE(hand_.ends.at(0).reason.empty());
    relay_->pull(false);
    connect_until_welcome();
    ASSERT_EQ(hand_.nonces.size(), 2U);
    EXPECT_NE(hand_.nonces[0], hand_.nonces[1]);
    run_for(milliseconds(100));
    finish();
    expect_accounted();
}

TEST_P(Faults, AKilledCoprocessorMayComeBack) {
    open({});
    connect_until_welcome();
    run_for(milliseconds(50));
    coprocessor_.session.reset();
    // With nothing said.
    connect_until_welcome();
    run_until([&] { return hand_.nonces.size() == 2 && hand_.session; });
    run_for(milliseconds(100));
    finish();
    expect_accounted();
}

TEST_P(Faults, AKilledHandMayComeBack) {
    options_.silence_limit = milliseconds(1500);
    open({});
    connect_until_welcome();
    run_for(milliseconds(50));
    hand_.session.reset();
    run_until([&] { return !coprocessor_.session; });
    connect_until_welcome();
    run_for(milliseconds(100));
    finish();
    expect_accounted();
}

// Ten years into its scene, where positions, counts and nanoseconds are large, and across the point where the
// position on the wire wraps.
TEST_P(Faults, TenYearsOnNothingIsDifferent) {
    const auto spans = std::chrono::duration_cast<Duration>(std::chrono::hours(24 * 3652)) / layout.span;
    const auto wrap = (spans / position_modulus + 1) * position_modulus;
    coprocessor_.start = scene_start + (wrap - 20) * layout.span;
    open({.loss = transport() == "tls" ? 0 : 0.05});
    connect_until_welcome();
    wait_for_echo(20us);  // a probe that is lost is sent again, and few packets are due meanwhile
    run_for(milliseconds(400));
    EXPECT_GT(coprocessor_.deadline, scene_start + (wrap + 20) * layout.span);
    finish();
    ASSERT_GT(hand_.events.size(), 20U);
    EXPECT_GE(hand_.events.front().time, coprocessor_.start);
    EXPECT_TRUE(std::includes(coprocessor_.sent.begin(), coprocessor_.sent.end(), hand_.events.begin(),
                              hand_.events.end()));
}

TEST_P(Faults, AnotherSceneOrVersionIsRefusedInWords) {
    open({});
    proto::Hello other_scene = hello(++nonce_);
    other_scene.set_scene_fingerprint(0x4321);
    proto::Hello other_version = hello(++nonce_);
    other_version.set_version(wire_version + 1);
    proto::Hello older_version = hello(++nonce_);
    older_version.set_version(0);
    for (const auto& [wrong, word] :
         {std::pair(other_scene, "the scenes differ"), std::pair(other_version, "wire version"),
          std::pair(older_version, "wire version")}) {
        const std::size_t ends = coprocessor_.ends.size();
        do {
            connect(wrong);
            run_until(
                [&] { return !unreached_.empty() || (coprocessor_.ends.size() > ends && !hand_.session); });
        } while (!unreached_.empty());
        EXPECT_NE(coprocessor_.ends.back().reason.find(word), std::string::npos)
            << coprocessor_.ends.back().reason;
        EXPECT_NE(hand_.ends.back().reason.find(word), std::string::npos) << hand_.ends.back().reason;
    }
    EXPECT_TRUE(hand_.nonces.empty());
}

}  // namespace
}  // namespace afferent
