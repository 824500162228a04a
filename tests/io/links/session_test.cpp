// Sessions over every transport: real sockets on this machine, and a pair of pseudo-terminals for the serial
// line.
#include "afferent/io/links/session.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <filesystem>
#include <random>

#include "afferent/io/links/transports.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "bench/serial_line.hpp"
#include "bench/short_lived_keys.hpp"
#include "tests/io/links/hello_message.hpp"
#include "tests/io/links/run_until.hpp"
#include "tests/io/links/transport_name.hpp"
#include "tests/io/links/turn_clock.hpp"
#include "tests/since_start.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

namespace asio = boost::asio;

std::vector<Event> events_on_ticks(std::size_t count, Duration duration) {
    std::mt19937_64 random(1);
    std::vector<Event> events(count);
    // On the begin of their ticks, so that they come back as they are.
    for (Event& event : events)
        event = {at((random() % static_cast<std::uint64_t>(duration / 100us)) * 100us),
                 static_cast<Address>(random() % 9)};
    std::sort(events.begin(), events.end());
    return events;
}

class TestHand final : public HandClient {
  public:
    void welcomed(const proto::Hello& hello) override { nonces.push_back(hello.nonce()); }
    void received(const Reception& reception) override {
        events.insert(events.end(), reception.events.begin(), reception.events.end());
        if (reception.gap) gaps.push_back(*reception.gap);
    }
    void clock(TimePoint time) override { clocks.push_back(time); }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd& end) override {
        ends.push_back(end);
        counts = session->receiver_counts();
        link = session->counts();
        session.reset();
    }

    std::unique_ptr<HandSession> session;
    std::vector<std::uint64_t> nonces;
    std::vector<Event> events;
    std::vector<TimeSpan> gaps;
    std::vector<TimePoint> clocks;
    std::vector<SessionEnd> ends;
    PacketCounts counts;
    LinkCounts link;
};

class TestCoprocessor final : public CoprocessorClient {
  public:
    void welcomed() override { ++welcomes; }
    void status(const proto::Status& status) override { gains.push_back(status.gain()); }
    bool acknowledged(const proto::Acknowledgement& acknowledgement) override {
        acknowledgements.push_back(acknowledgement);
        return packetizer == nullptr || packetizer->acknowledge(acknowledgement);
    }
    void samples(const proto::Samples& samples) override { forces.push_back(samples.force_n(0)); }
    proto::Bye answer_bye(const proto::Bye&) override { return bye; }
    void ended(const SessionEnd& end) override {
        ends.push_back(end);
        link = session->counts();
        session.reset();
    }

    std::unique_ptr<CoprocessorSession> session;
    int welcomes = 0;
    proto::Bye bye;
    Packetizer* packetizer = nullptr;
    std::vector<proto::Acknowledgement> acknowledgements;
    std::vector<double> gains;
    std::vector<double> forces;
    std::vector<SessionEnd> ends;
    LinkCounts link;
};

class Sessions : public testing::TestWithParam<const char*> {
  protected:
    Sessions()
        : socket_path_(std::filesystem::temp_directory_path() / ("afferent-" + std::to_string(getpid()))) {
        listener_ = value_or_throw(open_listener(io_, listening(), options_));
        address_ = listener_->address();
        const TlsCredentials coprocessor = keys_.credentials(LinkEnd::coprocessor);
        if (transport() == "serial") address_ = SerialAddress{line_.second(), 921'600, coprocessor};
        if (transport() == "udp_sealed") std::get<UdpAddress>(address_).credentials = coprocessor;
        listener_->start([this](std::unique_ptr<Link> link) {
            hand_.session =
                std::make_unique<HandSession>(std::move(link), expected_, hand_, limits_, time_.reader());
            hand_.session->start();
        });
    }

    static std::string transport() { return GetParam(); }
    static bool ordered() { return transport() == "unix" || transport() == "tcp"; }
    static bool sealed() { return transport() == "udp_sealed" || transport() == "serial"; }

    LinkAddress listening() const {
        if (transport() == "unix") return UnixAddress{socket_path_};
        if (transport() == "tcp") return TcpAddress{"127.0.0.1", 0};
        if (transport() == "udp") return UdpAddress{"127.0.0.1", 0, std::nullopt};
        if (transport() == "udp_sealed") return UdpAddress{"127.0.0.1", 0, keys_.credentials(LinkEnd::hand)};
        return SerialAddress{line_.first(), 921'600, keys_.credentials(LinkEnd::hand)};
    }

    void connect(TestCoprocessor& coprocessor, const proto::Hello& hello) {
        connector_ = make_connector(io_, address_, {}, options_);
        connector_->start([this, &coprocessor, hello](Result<std::unique_ptr<Link>> link) {
            ASSERT_TRUE(link) << link.error().text;
            coprocessor.session = std::make_unique<CoprocessorSession>(std::move(link).value(), hello,
                                                                       coprocessor, limits_, time_.reader());
            coprocessor.session->start();
        });
    }

    template <class Condition>
    void run_until(Condition condition) {
        afferent::run_until(io_, condition, [this] {
            time_.turn();
            if (hand_.session) hand_.session->poll();
            if (coprocessor_.session) coprocessor_.session->poll();
        });
    }

    // Where nothing but the wire holds packets back, they are given time to get through.
    void let_through() {
        if (ordered()) return;
        do {
            io_.restart();
            io_.run_one_for(std::chrono::milliseconds(1));
        } while (coprocessor_.session && coprocessor_.session->queued_bytes() > 0);
    }

    // The session's spikes are predicted, for neurons of the standard law.
    void foresee(const PacketLayout& layout) {
        describe(layout, expected_);
        proto::PatchAddresses& patch = *expected_.add_patch();
        patch.set_count(layout.addresses);
        const NeuronLaw law;
        patch.mutable_neuron()->set_tau_m_ms(law.tau_m_ms);
        patch.mutable_neuron()->set_tau_g_ms(law.tau_g_ms);
        patch.mutable_neuron()->set_v_r_mv(law.v_r_mv);
        patch.mutable_neuron()->set_v_th_mv(law.v_th_mv);
        patch.mutable_neuron()->set_e_k_mv(law.e_k_mv);
        patch.mutable_neuron()->set_delta_g(law.delta_g);
    }

    // A peer that knows nothing of sessions, and what it does with write(message, broken): a broken frame has
    // another checksum.
    template <class Use>
    void with_raw_peer(Use use) {
        const auto with = [&](auto socket, const auto& endpoint) {
            socket.connect(endpoint);
            FrameWriter writer;
            use([&](const proto::Envelope& message, bool broken) {
                const auto frame = writer.stream_frame(message);
                std::vector<std::byte> bytes(frame.begin(), frame.end());
                if (broken) bytes.back() ^= std::byte{1};
                asio::write(socket, asio::buffer(bytes.data(), bytes.size()));
            });
        };
        if (const auto* unix_address = std::get_if<UnixAddress>(&address_)) {
            using UnixStream = asio::local::stream_protocol;
            with(UnixStream::socket(io_), UnixStream::endpoint(unix_address->path));
        } else {
            const auto& [host, port] = std::get<TcpAddress>(address_);
            with(asio::ip::tcp::socket(io_), asio::ip::tcp::endpoint(asio::ip::make_address(host), port));
        }
    }

    std::filesystem::path socket_path_;
    ShortLivedKeys keys_;
    // Links keep to the wall clock, and the test may be held up for a second.
    LinkOptions options_{.silence_limit = std::chrono::milliseconds(1500),
                         .alive_limit = std::chrono::milliseconds(10'000)};
    TurnClock time_{20ms};
    asio::io_context io_;
    SerialLine line_{io_};
    proto::Hello expected_ = hello_of_nine();
    SessionLimits limits_;
    TestHand hand_;
    TestCoprocessor coprocessor_;
    LinkAddress address_;
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<Connector> connector_;
};

INSTANTIATE_TEST_SUITE_P(Transports, Sessions, testing::Values("unix", "tcp", "udp", "udp_sealed", "serial"),
                         transport_name);

class StreamSessions : public Sessions {};
INSTANTIATE_TEST_SUITE_P(Transports, StreamSessions, testing::Values("unix", "tcp"), transport_name);

// The peer is known by its address alone.
class PlainSessions : public Sessions {};
INSTANTIATE_TEST_SUITE_P(Transports, PlainSessions, testing::Values("unix", "tcp", "udp"), transport_name);

class DatagramSessions : public Sessions {};
INSTANTIATE_TEST_SUITE_P(Transports, DatagramSessions, testing::Values("udp", "udp_sealed", "serial"),
                         transport_name);

TEST_P(Sessions, CarryEveryEventAndEndWithBothSummaries) {
    const auto events = events_on_ticks(2000, 10s);
    Packetizer packetizer(PacketLayout{.addresses = 9});
    packetizer.push(events);
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    CoprocessorSession& session = *coprocessor_.session;
    packetizer.finish(at(10s), [&](const proto::Envelope& packet) {
        session.send_packet(packet);
        let_through();
    });
    session.send_clock(at(10s));
    proto::Bye bye;
    bye.set_time_ns(10'000'000'000);
    bye.set_packets(packetizer.packets());
    bye.set_events(packetizer.events());
    session.say_bye(bye);
    run_until([&] { return !hand_.ends.empty() && !coprocessor_.ends.empty(); });
    EXPECT_EQ(hand_.events, events);
    EXPECT_EQ(hand_.clocks, std::vector<TimePoint>{at(10s)});
    EXPECT_TRUE(hand_.gaps.empty());
    EXPECT_TRUE(hand_.ends.at(0).complete);
    EXPECT_TRUE(coprocessor_.ends.at(0).complete);
    EXPECT_EQ(hand_.ends.at(0).bye->events(), events.size());
    EXPECT_EQ(hand_.counts.packets, packetizer.packets());
    EXPECT_EQ(hand_.counts.lost_events, 0U);
}

TEST_P(Sessions, CarryStatusAndSamplesBack) {
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    proto::Status status;
    status.set_gain(0.25);
    hand_.session->send_status(status);
    proto::Samples samples;
    samples.add_force_n(1.5);
    hand_.session->send_samples(samples);
    run_until([&] { return !coprocessor_.forces.empty(); });
    EXPECT_EQ(coprocessor_.gains, std::vector<double>{0.25});
    EXPECT_EQ(coprocessor_.forces, std::vector<double>{1.5});
}

TEST_P(Sessions, OfTwoScenesAreRefusedOnBothSides) {
    proto::Hello other = hello_of_nine();
    other.set_scene_fingerprint(0x5678);
    connect(coprocessor_, other);
    run_until([&] { return !hand_.ends.empty() && !coprocessor_.ends.empty(); });
    EXPECT_EQ(hand_.ends.at(0).reason, "the coprocessor was refused: the scenes differ");
    EXPECT_EQ(coprocessor_.ends.at(0).reason, "the hand refuses: the scenes differ");
    EXPECT_FALSE(hand_.ends.at(0).complete);
    EXPECT_EQ(coprocessor_.welcomes, 0);
}

TEST_P(Sessions, StartAnewWhenThePeerIsGone) {
    const auto open = [&](int nonce) {
        proto::Hello hello = hello_of_nine();
        hello.set_nonce(static_cast<std::uint64_t>(nonce));
        connect(coprocessor_, hello);
        run_until([&] { return coprocessor_.session && coprocessor_.welcomes == nonce; });
    };
    open(1);
    // Killed: it sends no bye.
    coprocessor_.session.reset();
    run_until([&] { return hand_.ends.size() == 1; });
    EXPECT_FALSE(hand_.ends.at(0).complete);
    open(2);
    EXPECT_EQ(hand_.nonces, (std::vector<std::uint64_t>{1, 2}));
}

TEST_P(Sessions, EndForTheCoprocessorWhenTheHandIsGone) {
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    hand_.session.reset();
    run_until([&] { return !coprocessor_.ends.empty(); });
    EXPECT_FALSE(coprocessor_.ends.at(0).complete);
    EXPECT_FALSE(coprocessor_.ends.at(0).reason.empty());
}

TEST_P(Sessions, InterruptedByTheHandStillAccountForEverything) {
    const auto events = events_on_ticks(500, 1s);
    Packetizer packetizer(PacketLayout{.addresses = 9});
    packetizer.push(events);
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    coprocessor_.bye.set_time_ns(1'000'000'000);
    coprocessor_.bye.set_events(events.size());
    // The last packets are under way when the hand says it.
    packetizer.close(at(950ms), [&](const proto::Envelope& packet) {
        coprocessor_.session->send_packet(packet);
        let_through();
    });
    hand_.session->say_bye({});
    packetizer.finish(at(1s),
                      [&](const proto::Envelope& packet) { coprocessor_.session->send_packet(packet); });
    run_until([&] { return !hand_.ends.empty() && !coprocessor_.ends.empty(); });
    EXPECT_TRUE(hand_.ends.at(0).complete);
    EXPECT_TRUE(coprocessor_.ends.at(0).complete);
    EXPECT_EQ(hand_.events, events);
    // The reason of a peer that gave none is put in our words.
    EXPECT_EQ(coprocessor_.ends.at(0).reason, "this is the end of the scene");
}

TEST_P(PlainSessions, RefuseASecondCoprocessor) {
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    TestCoprocessor second;
    connect(second, hello_of_nine());
    run_until([&] {
        if (second.session) second.session->poll();
        return !second.ends.empty();
    });
    EXPECT_EQ(second.ends.at(0).reason, "the hand refuses: another coprocessor is connected");
    EXPECT_TRUE(second.ends.at(0).unanswered) << "a later attempt may succeed";
    EXPECT_EQ(listener_->refused_peers(), 1U);
    EXPECT_EQ(hand_.nonces.size(), 1U);
    EXPECT_TRUE(hand_.ends.empty());
}

TEST_P(StreamSessions, PutUpWithAFewBadFramesAndNoMore) {
    with_raw_peer([&](const auto& write) {
        proto::Envelope hello;
        *hello.mutable_hello() = hello_of_nine();
        write(hello, false);
        proto::Envelope packet;
        packet.set_position(6);
        for (int i = 0; i < 4; ++i) write(packet, true);
        // A good checksum, but no payload that could be.
        packet.set_payload("\xff\xff\xff");
        for (int i = 0; i < 4; ++i) write(packet, false);
        run_until([&] { return hand_.session && hand_.session->refused_messages() == 4; });
        EXPECT_EQ(hand_.session->counts().in.checksum_failures, 4U);
        write(packet, false);
        run_until([&] { return !hand_.ends.empty(); });
    });
    EXPECT_NE(hand_.ends.at(0).reason.find("too many bad frames"), std::string::npos)
        << hand_.ends.at(0).reason;
}

// Later packets could not be read without it.
TEST_P(StreamSessions, EndAtTheFirstBadFrameWhereEachPacketRefersToTheOneBefore) {
    foresee({.addresses = 9, .encoding = Encoding::predicted, .neurons = {{9, {}}}});
    with_raw_peer([&](const auto& write) {
        proto::Envelope hello;
        *hello.mutable_hello() = expected_;
        write(hello, false);
        proto::Envelope packet;
        packet.set_position(6);
        write(packet, false);
        run_until([&] { return hand_.session && hand_.session->receiver_counts().packets == 1; });
        write(packet, true);
        run_until([&] { return !hand_.ends.empty(); });
    });
    EXPECT_EQ(hand_.ends.at(0).reason.find("a frame is lost that later packets refer to: "), 0U)
        << hand_.ends.at(0).reason;
}

TEST_P(StreamSessions, EndWhenAPacketComesTwice) {
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    proto::Envelope packet;
    packet.set_position(6);
    coprocessor_.session->send_packet(packet);
    coprocessor_.session->send_packet(packet);
    run_until([&] { return !hand_.ends.empty() && !coprocessor_.ends.empty(); });
    EXPECT_NE(hand_.ends.at(0).reason.find("ordered link"), std::string::npos) << hand_.ends.at(0).reason;
}

// The hand reads nothing for a while: the oldest packets give way, nothing blocks, and the gap is known
// afterwards.
TEST_P(StreamSessions, DropTheOldestPacketsForASlowReader) {
    const PacketLayout layout{.addresses = 9};
    Packetizer packetizer(layout);
    std::vector<proto::Envelope> received;
    std::unique_ptr<Link> slow;
    listener_->start([&](std::unique_ptr<Link> link) { slow = std::move(link); });
    std::unique_ptr<Link> fast;
    // With nothing acknowledged for as long as the test takes.
    connector_ = make_connector(io_, address_, {}, {.silence_limit = std::chrono::minutes(1)});
    connector_->start([&](Result<std::unique_ptr<Link>> link) {
        fast = value_or_throw(std::move(link));
        fast->start({[](const proto::Envelope&) {}, [](const Error&) {}, [](const Error&) {}});
        fast->send(hello_message());
    });
    run_until([&] { return slow && fast; });
    // Several times as much as the queue and the kernel's buffers hold together.
    const auto events = events_on_ticks(300'000, 35s);
    packetizer.push(events);
    packetizer.finish(at(35s), [&](const proto::Envelope& packet) {
        if (!fast->send(packet)) packetizer.announce();
        io_.restart();
        io_.poll();
    });
    EXPECT_GT(fast->counts().dropped, 0U);
    EXPECT_LE(fast->queued_bytes(), LinkOptions{}.queue_bytes);
    bool closed = false;
    slow->start({[&](const proto::Envelope& packet) { received.push_back(packet); }, [](const Error&) {},
                 [&](const Error&) { closed = true; }});
    // What is closed has half a second to send the rest, which may be too little on a busy machine. The hello
    // is one more.
    run_until([&] { return received.size() == 1 + packetizer.packets() - fast->counts().dropped; });
    fast->close();
    run_until([&] { return closed; });
    PacketReceiver receiver(layout);
    ASSERT_TRUE(!received.empty() && received.front().has_hello());
    for (const auto& packet : std::span(received).subspan(1)) EXPECT_TRUE(receiver.receive(packet));
    receiver.finish(at(35s), events.size());
    EXPECT_EQ(receiver.counts().packets, packetizer.packets() - fast->counts().dropped);
    EXPECT_EQ(receiver.counts().events + receiver.counts().lost_events, events.size());
    EXPECT_GE(receiver.counts().gaps, 1U);
    EXPECT_EQ(receiver.end(), at(35s));
}

TEST_P(DatagramSessions, WaitForAPacketThatWasOvertakenAndIgnoreOneThatComesTwiceOrTooLate) {
    limits_.overtaking = 50ms;
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    proto::Envelope packet;
    const auto send = [&](std::initializer_list<std::uint32_t> positions) {
        for (const std::uint32_t position : positions) {
            packet.set_position(position);
            coprocessor_.session->send_packet(packet);
        }
    };
    const auto counts = [&] { return hand_.session->receiver_counts(); };
    send({6U, 16U, 16U, 11U, 21U});
    run_until([&] { return counts().packets == 4; });
    EXPECT_EQ(counts().out_of_order, 1U);
    EXPECT_EQ(counts().gaps, 0U);
    // A packet that does not come is waited for no longer than that; then it is too late.
    send({31U});
    run_until([&] { return counts().packets == 5; });
    EXPECT_EQ(counts().gaps, 1U);
    send({26U, 36U});
    run_until([&] { return counts().packets == 6; });
    EXPECT_EQ(counts().out_of_order, 2U);
    EXPECT_EQ(counts().gaps, 1U);
    EXPECT_TRUE(hand_.ends.empty());
}

TEST_P(DatagramSessions, AcknowledgePacketsThatReferToWhatHasBeen) {
    PacketLayout layout{
        .addresses = 9, .encoding = Encoding::predicted, .acknowledged = true, .neurons = {{9, {}}}};
    foresee(layout);
    Packetizer packetizer(layout);
    coprocessor_.packetizer = &packetizer;
    connect(coprocessor_, expected_);
    run_until([&] { return coprocessor_.welcomes == 1; });
    const std::vector<Event> events{{at(1ms), 0}, {at(11ms), 3}, {at(21ms), 3}};
    packetizer.push(events);
    for (std::size_t i = 0; i < events.size(); ++i) {
        packetizer.close(at((1 + 2 * static_cast<std::int64_t>(i)) * 5ms),
                         [&](const proto::Envelope& packet) { coprocessor_.session->send_packet(packet); });
        run_until([&] { return coprocessor_.acknowledgements.size() == i + 1; });
        // In spans of 5 ms, plus 1.
        EXPECT_EQ(coprocessor_.acknowledgements.back().position(), 2 * i + 2);
    }
    EXPECT_EQ(hand_.events, events);
    EXPECT_EQ(coprocessor_.session->refused_messages(), 0U);
    // What has not been sent cannot have been received.
    Packetizer younger(layout);
    coprocessor_.packetizer = &younger;
    packetizer.push(std::vector<Event>{{at(31ms), 4}});
    packetizer.close(at(35ms),
                     [&](const proto::Envelope& packet) { coprocessor_.session->send_packet(packet); });
    run_until([&] { return coprocessor_.session->refused_messages() == 1; });
    EXPECT_NE(coprocessor_.session->last_refusal().find("packets that have not been sent"),
              std::string::npos);
}

// Includes the handshake, the seals and what a line adds to them. Nothing is lost here: a hello or a bye that
// was repeated because the test was held up would arrive when its peer has left.
TEST_P(DatagramSessions, CountTheSameBytesAtBothEnds) {
    limits_.copies = limits_.repetition = std::chrono::minutes(1);
    for (const bool hand_says_bye : {false, true}) {
        connect(coprocessor_, hello_of_nine());
        run_until([&] { return coprocessor_.welcomes == 1; });
        coprocessor_.welcomes = 0;
        proto::Envelope packet;
        for (const std::uint32_t position : {6U, 11U, 16U, 21U}) {
            packet.set_position(position);
            coprocessor_.session->send_packet(packet);
        }
        hand_.session->send_status({});
        run_until([&] { return hand_.session->receiver_counts().packets == 4; });
        if (hand_says_bye)
            hand_.session->say_bye({});
        else
            coprocessor_.session->say_bye({});
        run_until([&] { return !hand_.session && !coprocessor_.session; });
        EXPECT_TRUE(hand_.ends.back().complete && coprocessor_.ends.back().complete);
        EXPECT_EQ(hand_.link.in.bytes, coprocessor_.link.bytes_out);
        EXPECT_EQ(coprocessor_.link.in.bytes, hand_.link.bytes_out);
        EXPECT_GT(hand_.link.bytes_out, sealed() ? 800U : 10U);
        EXPECT_EQ(hand_.link.dropped + coprocessor_.link.dropped, 0U);
    }
}

TEST_P(DatagramSessions, RepeatTheHelloUntilThereIsAnAnswer) {
    std::unique_ptr<Link> hand;
    int hellos = 0;
    proto::Envelope answer;
    answer.mutable_answer()->set_welcome(true);
    listener_->start([&](std::unique_ptr<Link> link) {
        hand = std::move(link);
        hand->start({[&](const proto::Envelope& message) {
                         // As if the first two had been lost.
                         if (!message.has_hello() || ++hellos < 3) return;
                         answer.mutable_answer()->set_nonce(message.hello().nonce());
                         hand->send(answer);
                     },
                     [](const Error&) {}, [](const Error&) {}});
    });
    proto::Hello hello = hello_of_nine();
    hello.set_nonce(5);
    connect(coprocessor_, hello);
    run_until([&] { return coprocessor_.welcomes == 1; });
    EXPECT_EQ(hellos, 3);
    // An answer that was repeated as well.
    hand->send(answer);
    hand->send(answer);
    proto::Envelope status;
    status.mutable_status()->set_gain(0.5);
    hand->send(status);
    run_until([&] { return !coprocessor_.gains.empty(); });
    EXPECT_EQ(coprocessor_.welcomes, 1);
    EXPECT_EQ(coprocessor_.session->refused_messages(), 0U);
}

TEST_P(DatagramSessions, RepeatTheLastWordUntilThereIsAnAnswer) {
    std::unique_ptr<Link> hand;
    int byes = 0;
    listener_->start([&](std::unique_ptr<Link> link) {
        hand = std::move(link);
        hand->start({[&](const proto::Envelope& message) {
                         proto::Envelope answer;
                         if (message.has_hello()) {
                             answer.mutable_answer()->set_welcome(true);
                             hand->send(answer);
                         } else if (message.has_bye() && ++byes == 3) {
                             answer.mutable_bye();
                             hand->send(answer);
                         }
                     },
                     [](const Error&) {}, [](const Error&) {}});
    });
    connect(coprocessor_, hello_of_nine());
    run_until([&] { return coprocessor_.welcomes == 1; });
    coprocessor_.session->say_bye({});
    run_until([&] { return !coprocessor_.ends.empty(); });
    EXPECT_TRUE(coprocessor_.ends.at(0).complete);
    EXPECT_EQ(byes, 3);
}

TEST_P(DatagramSessions, AnswerTheSameHelloAgainAndEndAtAnother) {
    std::unique_ptr<Link> link;
    connector_ = make_connector(io_, address_, {}, options_);
    connector_->start([&](Result<std::unique_ptr<Link>> made) { link = value_or_throw(std::move(made)); });
    run_until([&] { return link != nullptr; });
    std::vector<std::uint64_t> answered;
    link->start({[&](const proto::Envelope& message) {
                     if (message.has_answer()) answered.push_back(message.answer().nonce());
                 },
                 [](const Error&) {}, [](const Error&) {}});
    proto::Envelope hello;
    *hello.mutable_hello() = hello_of_nine();
    hello.mutable_hello()->set_nonce(1);
    // Late messages of an earlier session come before it, and do no harm.
    proto::Envelope early;
    early.set_position(6);
    link->send(early);
    early.Clear();
    early.mutable_bye();
    link->send(early);
    for (int i = 0; i < 3; ++i) link->send(hello);
    run_until([&] { return answered.size() == 3; });
    EXPECT_EQ(answered, (std::vector<std::uint64_t>{1, 1, 1}));
    EXPECT_EQ(hand_.nonces, std::vector<std::uint64_t>{1});
    EXPECT_EQ(hand_.session->state(), Session::State::open);
    hello.mutable_hello()->set_nonce(2);
    link->send(hello);
    run_until([&] { return hand_.ends.size() == 1; });
    EXPECT_EQ(hand_.ends.at(0).reason, "the coprocessor has started again");
}

TEST(Connector, GivesUpAfterAWhileAndSaysWhy) {
    asio::io_context io;
    const ShortLivedKeys keys;
    const TlsCredentials own = keys.credentials(LinkEnd::coprocessor);
    for (const LinkAddress& nobody :
         {LinkAddress(UnixAddress{"/nowhere/afferent.sock"}), LinkAddress(TcpAddress{"127.0.0.1", 1}),
          LinkAddress(UdpAddress{"127.0.0.1", 1, std::nullopt}), LinkAddress(UdpAddress{"127.0.0.1", 1, own}),
          LinkAddress(SerialAddress{"/nowhere/ttyS0", 115'200, own})}) {
        const auto connector = make_connector(
            io, nobody,
            {std::chrono::milliseconds(1), std::chrono::milliseconds(4), std::chrono::milliseconds(30)});
        std::string reason;
        connector->start([&](Result<std::unique_ptr<Link>> link) {
            ASSERT_FALSE(link);
            EXPECT_EQ(link.error().kind, Error::Kind::unreachable);
            reason = link.error().text;
        });
        io.restart();
        io.run();
        EXPECT_EQ(reason.find(text(nobody)), 0U) << reason;
        EXPECT_NE(reason.find("tried for 30 ms"), std::string::npos) << reason;
    }
}

TEST(Connector, WaitsForAListenerToAppear) {
    asio::io_context io;
    const LinkAddress address =
        UnixAddress{std::filesystem::temp_directory_path() / ("afferent-late-" + std::to_string(getpid()))};
    const auto connector = make_connector(io, address);
    bool connected = false;
    connector->start([&](Result<std::unique_ptr<Link>> link) { connected = link.has_value(); });
    io.run_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(connected);
    const auto listener = open_listener(io, address);
    ASSERT_TRUE(listener) << listener.error().text;
    listener.value()->start([](std::unique_ptr<Link>) {});
    run_until(
        io, [&] { return connected; }, [] {});
}

TEST(Listener, ListensNoLongerThanItLives) {
    asio::io_context io;
    auto listener = value_or_throw(open_listener(io, TcpAddress{"127.0.0.1", 0}));
    listener->start([](std::unique_ptr<Link>) {});
    const std::uint16_t port = std::get<TcpAddress>(listener->address()).port;
    listener.reset();
    asio::ip::tcp::socket peer(io);
    boost::system::error_code error;
    peer.connect({asio::ip::make_address("127.0.0.1"), port}, error);
    EXPECT_EQ(error, asio::error::connection_refused);
}

TEST(Listener, LeavesTheMachineOnlyWithKeys) {
    asio::io_context io;
    for (const char* host : {"0.0.0.0", "192.0.2.1", "::"}) {
        const auto listener = open_listener(io, TcpAddress{host, 0});
        ASSERT_FALSE(listener);
        EXPECT_EQ(listener.error().kind, Error::Kind::not_allowed);
        EXPECT_NE(listener.error().text.find("only a link with keys may"), std::string::npos);
        const auto plain = open_listener(io, UdpAddress{host, 0, std::nullopt});
        ASSERT_FALSE(plain);
        EXPECT_EQ(plain.error().kind, Error::Kind::not_allowed);
    }
    const ShortLivedKeys keys;
    EXPECT_TRUE(open_listener(io, UdpAddress{"0.0.0.0", 0, keys.credentials(LinkEnd::hand)}));
    EXPECT_EQ(error_or_throw(open_listener(io, TcpAddress{"example.org", 0})).kind, Error::Kind::not_allowed);
    EXPECT_EQ(error_or_throw(open_listener(io, UnixAddress{std::string(200, 'x')})).kind,
              Error::Kind::not_allowed);
}

TEST(Listener, ReplacesASocketThatNobodyListensTo) {
    asio::io_context io;
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("afferent-abandoned-" + std::to_string(getpid()));
    {
        asio::local::stream_protocol::acceptor abandoned(io, path.string());
        const auto second = open_listener(io, UnixAddress{path});
        ASSERT_FALSE(second);
        EXPECT_NE(second.error().text.find("in use"), std::string::npos) << second.error().text;
    }
    EXPECT_TRUE(std::filesystem::exists(path));
    EXPECT_TRUE(open_listener(io, UnixAddress{path}));
    EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace afferent
