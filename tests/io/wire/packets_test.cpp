#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/counts_nothing.hpp"
#include "tests/io/wire/packet_streams.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

TEST(PacketLayout, NamesTheFieldThatIsWrong) {
    const auto field = [](auto change) {
        PacketLayout layout;
        change(layout);
        try {
            layout.check();
        } catch (const ParameterError& error) {
            return error.field();
        }
        return std::string();
    };
    EXPECT_EQ(field([](PacketLayout&) {}), "");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.addresses = 0; }), "addresses");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.tick = 0ns; }), "tick_us");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.span = 5ms + 1us; }), "packet_ms");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.heartbeat = 4ms; }), "heartbeat_ms");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.max_events = 0; }), "packet_events");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.addresses = 4'000'000'000; }), "packet_ms");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.gathered_spans = 5; }), "");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.gathered_spans = 6; }), "packet_ms")
        << "a heartbeat is 5";
    EXPECT_EQ(field([](PacketLayout& layout) { layout.gathered_spans = 0; }), "packet_ms");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.addresses = 85'899'345; }), "") << "2^32 - 46 codes";
    EXPECT_EQ(field([](PacketLayout& layout) { layout.addresses = 85'899'346; }), "packet_ms");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.addresses = 85'899'345, layout.gathered_spans = 2; }),
              "packet_ms");

    // Where spikes are predicted.
    const auto predicted_field = [&](auto change) {
        return field([&](PacketLayout& layout) {
            layout.addresses = 9;
            layout.encoding = Encoding::predicted;
            layout.tolerance = 1ms;
            layout.neurons = {{9, {}}};
            change(layout, layout.neurons[0].law);
        });
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(predicted_field([](auto&, auto&) {}), "");
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.addresses = 10; }), "addresses");
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.tolerance = 2500us; }), "timing_tolerance_us");
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.tolerance = 50us; }), "timing_tolerance_us")
        << "half a tick, as where milliseconds are taken for microseconds";
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.tolerance = -100us; }), "timing_tolerance_us");
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.gathered_spans = 2; }), "prompt_ms");
    EXPECT_EQ(predicted_field(
                  [](auto& layout, auto&) { layout.tick = 1us, layout.span = layout.heartbeat = 66ms; }),
              "packet_ms");
    EXPECT_EQ(predicted_field(
                  [](auto& layout, auto&) { layout.addresses = layout.neurons[0].addresses = 120'000; }),
              "encoding");
    EXPECT_EQ(predicted_field([&](auto&, auto& law) { law.tau_m_ms = nan; }), "tau_m_ms");
    EXPECT_EQ(predicted_field([](auto&, auto& law) { law.tau_g_ms = 0; }), "tau_g_ms");
    EXPECT_EQ(predicted_field([](auto&, auto& law) { law.v_th_mv = -70; }), "v_th_mv");
    EXPECT_EQ(predicted_field([&](auto&, auto& law) { law.v_r_mv = nan; }), "v_r_mv");
    EXPECT_EQ(predicted_field([](auto&, auto& law) { law.delta_g = -1; }), "delta_g");
    EXPECT_EQ(predicted_field([&](auto&, auto& law) { law.refractory_ms = nan; }), "refractory_ms");

    // The last that are allowed, and the first that are not.
    const Duration ns(1);
    EXPECT_EQ(field([&](PacketLayout& layout) { layout.tick = -ns; }), "tick_us");
    const auto one_tick = [](Duration tick) {
        return [tick](PacketLayout& layout) { layout.tick = layout.span = layout.heartbeat = tick; };
    };
    EXPECT_EQ(field(one_tick(ns)), "");
    EXPECT_EQ(field(one_tick(1s)), "");
    EXPECT_EQ(field(one_tick(1s + ns)), "tick_us");
    const auto one_span = [](Duration span) {
        return [span](PacketLayout& layout) { layout.tick = 1ns, layout.span = layout.heartbeat = span; };
    };
    EXPECT_EQ(field([&](PacketLayout& layout) { layout.span = 0ns; }), "packet_ms");
    EXPECT_EQ(field(one_span(4s)), "");
    EXPECT_EQ(field(one_span(4s + ns)), "packet_ms");
    EXPECT_EQ(field([&](PacketLayout& layout) { layout.heartbeat = 5ms; }), "");
    EXPECT_EQ(field([&](PacketLayout& layout) { layout.heartbeat = 5ms - ns; }), "heartbeat_ms");
    EXPECT_EQ(field([&](PacketLayout& layout) { layout.heartbeat = 8000 * 5ms - ns; }), "");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.heartbeat = 8000 * 5ms; }), "heartbeat_ms");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.max_events = 1; }), "");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.max_events = 50'000; }), "");
    EXPECT_EQ(field([](PacketLayout& layout) { layout.max_events = 50'001; }), "packet_events");
    EXPECT_EQ(predicted_field(
                  [](auto& layout, auto&) { layout.tick = 1us, layout.span = layout.heartbeat = 65'536us; }),
              "");
    EXPECT_EQ(predicted_field(
                  [](auto& layout, auto&) { layout.tick = 1us, layout.span = layout.heartbeat = 65'537us; }),
              "packet_ms");
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.tolerance = 0ns; }), "");
    EXPECT_EQ(predicted_field([](auto& layout, auto&) { layout.tolerance = 2400us; }), "");
    const auto for_laws = [&](const char* name, double NeuronLaw::*member, std::initializer_list<double> bad,
                              double good) {
        for (const double value : bad)
            EXPECT_EQ(predicted_field([&](auto&, auto& law) { law.*member = value; }), name) << value;
        EXPECT_EQ(predicted_field([&](auto&, auto& law) { law.*member = good; }), "") << name;
    };
    for_laws("tau_m_ms", &NeuronLaw::tau_m_ms, {0, -1, 1e12}, 9e11);
    for_laws("tau_g_ms", &NeuronLaw::tau_g_ms, {0, -1, 1e12}, 9e11);
    for_laws("v_th_mv", &NeuronLaw::v_th_mv, {NeuronLaw().e_k_mv, std::numeric_limits<double>::infinity()},
             NeuronLaw().v_r_mv + 1e-9);
    for_laws("v_r_mv", &NeuronLaw::v_r_mv, {NeuronLaw().v_th_mv, -std::numeric_limits<double>::infinity()},
             NeuronLaw().v_th_mv - 1e-9);
    for_laws("delta_g", &NeuronLaw::delta_g, {-1e-9}, 0);
    for_laws("refractory_ms", &NeuronLaw::refractory_ms, {-1e-9}, 0);
}

TEST(Packets, AreCountedFromNothing) { EXPECT_TRUE(counts_nothing<PacketCounts>()); }

TEST(Packets, BringEveryEventToItsTick) {
    std::mt19937_64 random(1);
    for (const Encoding encoding : {Encoding::rice, Encoding::fixed_width})
        for (const Duration tick : {Duration(1us), Duration(100us), Duration(1ms)})
            for (const Address addresses : {1U, 9U, 1000U, 100'000U}) {
                PacketLayout layout = layout_of(addresses);
                layout.tick = tick;
                layout.encoding = encoding;
                layout.max_events = 100;
                const auto events = random_events(random, layout, 5000, 2s);
                PacketReceiver receiver(layout);
                const Received received = receive_all(receiver, packets_of(layout, events, at(2s)));
                EXPECT_EQ(received.events, on_ticks(events, tick));
                EXPECT_TRUE(received.gaps.empty());
                EXPECT_EQ(receiver.counts().events, 5000U);
                EXPECT_EQ(receiver.counts().lost_events, 0U);
            }
}

TEST(Packets, CoverTimeWithoutHoles) {
    std::mt19937_64 random(2);
    const PacketLayout layout = layout_of(9);
    const auto packets = packets_of(layout, random_events(random, layout, 300, 10s), at(10s + 1ns));
    PacketReceiver receiver(layout);
    const Received received = receive_all(receiver, packets);
    TimePoint end = scene_start;
    for (const TimeSpan& known : received.known) {
        EXPECT_EQ(known.begin, end);
        EXPECT_GT(known.end, known.begin);
        EXPECT_LE(known.end - known.begin, layout.heartbeat);
        end = known.end;
    }
    EXPECT_EQ(end, at(10s + 5ms));
    EXPECT_EQ(receiver.end(), end);
    EXPECT_LT(packets.size(), 1000U);
}

TEST(Packets, AreTheSameHoweverTheCallsAreSpread) {
    std::mt19937_64 random(3);
    PacketLayout layout = layout_of(20);
    layout.max_events = 3;
    const auto events = random_events(random, layout, 2000, 3s);
    std::vector<std::string> at_once;
    for (const auto& packet : packets_of(layout, events, at(3s)))
        at_once.push_back(packet.SerializeAsString());

    Packetizer packetizer(layout);
    std::vector<std::string> piecewise;
    const auto sink = [&](const proto::Envelope& packet) { piecewise.push_back(packet.SerializeAsString()); };
    std::size_t pushed = 0;
    for (TimePoint deadline = at(5ms); deadline <= at(3s); deadline += 5ms) {
        // Up to a few milliseconds beyond the deadline, or just all that is due.
        const TimePoint until = deadline + Duration(random() % 7'000'000);
        const auto first = events.begin() + static_cast<std::ptrdiff_t>(pushed);
        const auto last =
            std::partition_point(first, events.end(), [&](const Event& e) { return e.time < until; });
        packetizer.push({first, last});
        pushed = static_cast<std::size_t>(last - events.begin());
        packetizer.close(deadline, sink);
    }
    packetizer.finish(at(3s), sink);
    EXPECT_EQ(piecewise, at_once);
}

TEST(Packets, TakeAnEventAtTheDeadlineIntoTheNext) {
    const PacketLayout layout = layout_of(9);
    PacketReceiver receiver(layout);
    const Received received =
        receive_all(receiver, packets_of(layout, {{at(5ms - 1ns), 8}, {at(5ms), 0}}, at(10ms)));
    EXPECT_EQ(received.events, (std::vector<Event>{{at(4900us), 8}, {at(5ms), 0}}));
    EXPECT_EQ(received.known, (std::vector<TimeSpan>{{at(0ms), at(5ms)}, {at(5ms), at(10ms)}}));
}

TEST(Packets, ReportSilenceAtTheHeartbeatInAtMostTwelveBytes) {
    PacketLayout layout = layout_of(1000);
    layout.heartbeat = 23ms;  // rounded up to five spans
    // A touch, then ten minutes of nothing.
    std::mt19937_64 random(4);
    const auto packets = packets_of(layout, random_events(random, layout, 100'000, 1s), at(600s));
    std::size_t silent = 0;
    FrameWriter writer;
    for (const auto& packet : packets)
        if (packet.payload().empty()) {
            ++silent;
            EXPECT_LE(writer.stream_frame(packet).size(), 12U);
        }
    EXPECT_EQ(silent, 599U * 40);
    PacketReceiver receiver(layout);
    receive_all(receiver, packets);
    EXPECT_EQ(receiver.end(), at(600s));
}

TEST(Packets, LeaveAKnownGapWhenLost) {
    std::mt19937_64 random(5);
    for (const std::uint32_t max_events : {4096U, 2U}) {
        PacketLayout layout = layout_of(9);
        layout.max_events = max_events;
        const auto events = random_events(random, layout, 4000, 10s);
        const auto sent = on_ticks(events, layout.tick);
        const auto packets = packets_of(layout, events, at(10s));
        std::vector<proto::Envelope> arrived;
        for (const auto& packet : packets)
            if (random() % 4 != 0) arrived.push_back(packet);
        PacketReceiver receiver(layout);
        Received received = receive_all(receiver, arrived);
        if (const auto gap = receiver.finish(at(10s), events.size())) received.gaps.push_back(*gap);

        // Every event was delivered or lies in a reported gap, and all are accounted for.
        EXPECT_EQ(receiver.counts().events + receiver.counts().lost_events, events.size());
        std::vector<Event> missing;
        std::set_difference(sent.begin(), sent.end(), received.events.begin(), received.events.end(),
                            std::back_inserter(missing));
        EXPECT_EQ(missing.size(), receiver.counts().lost_events);
        for (const Event& event : missing)
            EXPECT_TRUE(std::any_of(received.gaps.begin(), received.gaps.end(), [&](const TimeSpan& gap) {
                return gap.begin <= event.time && event.time < gap.end;
            }));
        // Gaps do not overlap each other, and together with the known spans they cover all time.
        Duration unknown{};
        TimePoint end = scene_start;
        for (const TimeSpan& gap : received.gaps) {
            EXPECT_LT(gap.begin, gap.end);
            EXPECT_GE(gap.begin, end);
            end = gap.end;
            unknown += gap.end - gap.begin;
        }
        EXPECT_EQ(unknown, receiver.counts().unknown);
        EXPECT_EQ(receiver.counts().gaps, received.gaps.size());
        EXPECT_EQ(receiver.end(), at(10s));
    }
}

// Spans of 1 ms, of which packets gather five, and a heartbeat of 25.
PacketLayout prompt_layout() {
    PacketLayout layout = layout_of(9);
    layout.span = 1ms;
    layout.gathered_spans = 5;
    return layout;
}

std::vector<TimeSpan> spans_of_packets(const PacketLayout& layout, const std::vector<Event>& events,
                                       TimePoint end) {
    PacketReceiver receiver(layout);
    const Received received = receive_all(receiver, packets_of(layout, events, end));
    EXPECT_EQ(received.events, on_ticks(events, layout.tick));
    EXPECT_TRUE(received.gaps.empty());
    return received.known;
}

TEST(PromptPackets, CloseAtOnceWhileATouchBegins) {
    const auto known = spans_of_packets(prompt_layout(),
                                        {{at(31200us), 0},
                                         {at(33900us), 1},
                                         {at(33950us), 2},
                                         {at(56100us), 3},
                                         {at(57100us), 4},
                                         {at(58300us), 5},
                                         {at(61000us), 6}},
                                        at(80ms));
    // The touch begins in the span that ends at 32 ms, and the beginning with the one that ends at 57 ms.
    EXPECT_EQ(known, (std::vector<TimeSpan>{{at(0ms), at(25ms)},
                                            {at(25ms), at(32ms)},
                                            {at(32ms), at(34ms)},
                                            {at(34ms), at(57ms)},
                                            {at(57ms), at(60ms)},
                                            {at(60ms), at(65ms)},
                                            {at(65ms), at(80ms)}}));
}

// A silence of just a heartbeat ends no touch; one span more does.
TEST(PromptPackets, FollowASilenceThatIsLongerThanAHeartbeat) {
    const auto packet_ends = [](Duration second) {
        const auto known = spans_of_packets(
            prompt_layout(), {{at(100us), 0}, {at(10500us), 1}, {at(26500us), 2}, {at(second), 3}},
            at(100ms));
        std::vector<TimePoint> ends;
        for (const TimeSpan& span : known) ends.push_back(span.end);
        return ends;
    };
    EXPECT_EQ(packet_ends(51500us),
              (std::vector<TimePoint>{at(1ms), at(11ms), at(30ms), at(55ms), at(80ms), at(100ms)}));
    EXPECT_EQ(packet_ends(52500us),
              (std::vector<TimePoint>{at(1ms), at(11ms), at(30ms), at(53ms), at(78ms), at(100ms)}));
}

// The silence before a packet and the events of it are no longer than a heartbeat together.
TEST(PromptPackets, KeepToTheHeartbeat) {
    std::mt19937_64 random(9);
    PacketLayout layout = prompt_layout();
    layout.max_events = 2;
    for (const std::size_t count : {300U, 3'000U}) {
        TimePoint end = scene_start;
        for (const TimeSpan& known :
             spans_of_packets(layout, random_events(random, layout, count, 10s), at(10s))) {
            EXPECT_TRUE(known.begin == end || known.end == end) << "the next, or another part of it";
            EXPECT_LE(known.end - known.begin, layout.heartbeat);
            end = known.end;
        }
        EXPECT_EQ(end, at(10s));
    }
}

// Nothing is known of the spans that may hold what is missing.
TEST(PromptPackets, ThatAreNotCompleteAreAGap) {
    const PacketLayout layout = prompt_layout();
    PayloadCodec codec(layout);
    const auto packet = [&](std::uint32_t position, std::uint32_t part, bool more, std::uint32_t spans) {
        proto::Envelope made;
        made.set_position(position + 1);
        made.set_part(part);
        made.set_more(more);
        made.set_spans(spans);
        codec.encode(std::array<Code, 1>{8}, *made.mutable_payload(), layout.spans_with_events(spans));
        return made;
    };
    PacketReceiver goes_on(layout);
    const Reception first = value_or_throw(goes_on.receive(packet(10, 0, true, 8)));
    EXPECT_EQ(first.known, (TimeSpan{at(2ms), at(10ms)}));
    EXPECT_EQ(first.events.front(), (Event{at(5ms), 8})) << "from the first span that may hold events";
    EXPECT_EQ(value_or_throw(goes_on.receive(packet(12, 0, false, 2))).gap, (TimeSpan{at(5ms), at(10ms)}));
    PacketReceiver begins_later(layout);
    EXPECT_EQ(value_or_throw(begins_later.receive(packet(10, 1, true, 10))).gap,
              (TimeSpan{at(5ms), at(10ms)}));
    PacketReceiver lacks_one(layout);
    ASSERT_TRUE(lacks_one.receive(packet(10, 0, true, 10)));
    EXPECT_EQ(value_or_throw(lacks_one.receive(packet(10, 2, false, 10))).gap, (TimeSpan{at(5ms), at(10ms)}));
}

TEST(PromptPackets, CountTheEventsOfAGap) {
    std::mt19937_64 random(10);
    PacketLayout layout = prompt_layout();
    layout.max_events = 2;
    const auto events = random_events(random, layout, 4000, 20s);
    PacketReceiver receiver(layout);
    Received received;
    for (const auto& packet : packets_of(layout, events, at(20s)))
        if (random() % 4 != 0) take(received, value_or_throw(receiver.receive(packet)));
    if (const auto gap = receiver.finish(at(20s), events.size())) received.gaps.push_back(*gap);
    const auto sent = on_ticks(events, layout.tick);
    std::vector<Event> missing;
    std::set_difference(sent.begin(), sent.end(), received.events.begin(), received.events.end(),
                        std::back_inserter(missing));
    EXPECT_EQ(missing.size(), receiver.counts().lost_events);
    EXPECT_GT(missing.size(), 500U);
    for (const Event& event : missing)
        EXPECT_TRUE(std::any_of(received.gaps.begin(), received.gaps.end(), [&](const TimeSpan& gap) {
            return gap.begin <= event.time && event.time < gap.end;
        }));
}

TEST(Packets, FromThePastAreRefusedAndChangeNothing) {
    std::mt19937_64 random(6);
    const PacketLayout layout = layout_of(9);
    const auto events = random_events(random, layout, 3000, 10s);
    const auto packets = packets_of(layout, events, at(10s));
    PacketReceiver receiver(layout);
    Received received;
    for (std::size_t i = 0; i < packets.size(); ++i) {
        const Result<Reception> reception = receiver.receive(packets[i]);
        ASSERT_TRUE(reception);
        take(received, reception.value());
        const Result<Reception> again = receiver.receive(packets[i - random() % (i + 1)]);
        ASSERT_FALSE(again);
        EXPECT_EQ(again.error().kind, Error::Kind::out_of_order);
    }
    EXPECT_EQ(received.events, on_ticks(events, layout.tick));
    EXPECT_EQ(receiver.counts().out_of_order, packets.size());
}

TEST(Packets, GoOnWhenPositionsAndCountsWrap) {
    std::mt19937_64 random(7);
    PacketLayout layout = layout_of(100'000);
    layout.span = layout.heartbeat = 1ms;
    layout.max_events = 50'000;
    // Three million events wrap the 21 bits of a silent packet's count; 40 s wrap the position of 1 ms spans
    // twice.
    const auto events = random_events(random, layout, 3'000'000, 39s);
    const auto packets = packets_of(layout, events, at(40s));
    PacketReceiver receiver(layout);
    std::uint64_t received = 0;
    for (const auto& packet : packets) {
        if (random() % 100 == 0) continue;
        const Result<Reception> reception = receiver.receive(packet);
        ASSERT_TRUE(reception) << reception.error().text;
        received += reception.value().events.size();
    }
    EXPECT_EQ(received + receiver.counts().lost_events, events.size());
    EXPECT_EQ(receiver.end(), at(40s));
}

TEST(Packets, BeginAnywhereInTheSceneAndSurviveTheLossOfTheFirst) {
    const PacketLayout layout = layout_of(9);
    for (const Duration begin : {Duration(35ms), Duration(41s), Duration(100h)}) {
        Packetizer packetizer(layout);
        packetizer.begin_at(at(begin));
        packetizer.push(std::vector<Event>{{at(begin + 12ms), 3}, {at(begin + 17ms), 4}});
        std::vector<proto::Envelope> packets;
        packetizer.finish(at(begin + 1s), [&](const proto::Envelope& packet) { packets.push_back(packet); });
        PacketReceiver receiver(layout);
        const Received received = receive_all(receiver, {packets.begin() + 1, packets.end()});
        EXPECT_EQ(received.events, (std::vector<Event>{{at(begin + 17ms), 4}}));
        EXPECT_EQ(received.gaps, (std::vector<TimeSpan>{{at(0ms), at(begin + 15ms)}}));
        EXPECT_EQ(receiver.counts().lost_events, 1U);
        EXPECT_EQ(receiver.end(), at(begin + 1s));
    }
}

TEST(Packets, ThatContradictTheSessionAreRefused) {
    const PacketLayout layout = layout_of(9);
    PacketReceiver receiver(layout);
    PayloadCodec codec(layout);
    const auto refusal = [&](auto change) -> std::string {
        proto::Envelope packet;
        packet.set_position(11);
        codec.encode(std::array<Code, 1>{20}, *packet.mutable_payload());
        change(packet);
        const Result<Reception> reception = receiver.receive(packet);
        if (reception) return "accepted";
        return reception.error().kind == Error::Kind::malformed ? reception.error().text : "not malformed";
    };
    const std::string impossible = "packet: has an impossible position";
    EXPECT_EQ(refusal([](auto& packet) { packet.set_position(0); }), impossible);
    EXPECT_EQ(refusal([](auto& packet) { packet.set_position(16'384); }), impossible);
    EXPECT_EQ(refusal([](auto& packet) { packet.set_spans(6); }),
              "packet: is longer than the heartbeat allows");
    EXPECT_EQ(refusal([](auto& packet) { packet.set_position(3), packet.set_spans(3); }),
              "packet: begins before the end of the one before it");
    EXPECT_EQ(refusal([](auto& packet) { packet.set_count(1U << 28); }),
              "packet: has an impossible running count");
    EXPECT_EQ(refusal([](auto& packet) { packet.clear_payload(), packet.set_count(1U << 21); }),
              "packet: has an impossible running count");
    const std::string empty = "packet: a part is empty";
    EXPECT_EQ(refusal([](auto& packet) { packet.clear_payload(), packet.set_more(true); }), empty);
    EXPECT_EQ(refusal([](auto& packet) { packet.clear_payload(), packet.set_part(1); }), empty);
    EXPECT_NE(refusal([](auto& packet) { packet.set_payload("\x02"); }), "accepted");
    EXPECT_EQ(refusal([](auto& packet) { packet.set_begin(11); }),
              "packet: has a begin and a position that disagree");
    EXPECT_EQ(refusal([](auto& packet) { packet.set_begin(~std::uint64_t{0}); }),
              "packet: begins at an impossible time");
    EXPECT_EQ(receiver.counts().refused, 11U);
    EXPECT_EQ(refusal([](auto& packet) { packet.set_position(2), packet.set_count(5); }),
              "packet: counts more events than were sent, though no packet is missing");
    EXPECT_EQ(receiver.end(), scene_start);
    EXPECT_EQ(
        refusal([](auto& packet) { packet.set_begin(5), packet.set_position(11), packet.set_spans(5); }),
        "accepted");
    EXPECT_EQ(receiver.end(), at(50ms));
}

// A part with another span would take back what was said of the packet's span.
TEST(Packets, HavePartsThatAgreeOrAreRefused) {
    const PacketLayout layout = layout_of(9);
    PayloadCodec codec(layout);
    const auto part = [&](std::uint32_t number, std::vector<Code> codes, bool more) {
        proto::Envelope packet;
        packet.set_position(4);
        packet.set_spans(2);
        packet.set_part(number);
        packet.set_more(more);
        codec.encode(codes, *packet.mutable_payload());
        return packet;
    };
    const auto refused = [](const Result<Reception>& reception) {
        return !reception && reception.error().kind == Error::Kind::malformed;
    };
    PacketReceiver receiver(layout);
    const Result<Reception> first = receiver.receive(part(0, {20, 30}, true));
    ASSERT_TRUE(first);
    EXPECT_EQ(first.value().known, (TimeSpan{at(5ms), at(15ms)}));
    proto::Envelope longer = part(1, {40}, false);
    longer.set_spans(3);
    EXPECT_TRUE(refused(receiver.receive(longer)));
    EXPECT_TRUE(refused(receiver.receive(part(1, {29}, false))));
    ASSERT_TRUE(receiver.receive(part(1, {30, 31}, true)));
    // No number comes after the highest.
    ASSERT_TRUE(receiver.receive(part(~std::uint32_t{0}, {32}, true)));
    const Result<Reception> again = receiver.receive(part(0, {33}, false));
    EXPECT_TRUE(!again && again.error().kind == Error::Kind::out_of_order);
}

// By hand: one event in each part, of a span of 5 ms unless it says otherwise.
class HandMadePackets : public testing::Test {
  protected:
    // The span that ends at `position` spans after the start of the scene.
    proto::Envelope packet(std::uint32_t position, std::uint32_t part = 0, bool more = false,
                           std::uint32_t spans = 0) {
        proto::Envelope packet;
        packet.set_position(position + 1);
        packet.set_part(part);
        packet.set_more(more);
        packet.set_spans(spans);
        codec_.encode(std::array<Code, 1>{20 + part}, *packet.mutable_payload());
        return packet;
    }
    std::optional<TimeSpan> gap(PacketReceiver& receiver, const proto::Envelope& packet) {
        const Result<Reception> reception = receiver.receive(packet);
        EXPECT_TRUE(reception) << reception.error().text;
        return reception ? reception.value().gap : std::nullopt;
    }

    const PacketLayout layout_ = layout_of(9);
    PayloadCodec codec_{layout_};
};

// An event may be missing after the last that has come: nothing is known of the packet's last span.
TEST_F(HandMadePackets, ThatAreNotCompleteAreAGap) {
    PacketReceiver goes_on(layout_);
    EXPECT_EQ(gap(goes_on, packet(1, 0, true)), std::nullopt);
    EXPECT_EQ(gap(goes_on, packet(2)), (TimeSpan{at(0ms), at(5ms)}));
    PacketReceiver ends(layout_);
    EXPECT_EQ(gap(ends, packet(1, 0, true)), std::nullopt);
    EXPECT_EQ(ends.finish(at(5ms), 1), (TimeSpan{at(0ms), at(5ms)}));
    EXPECT_EQ(ends.finish(at(5ms), 1), std::nullopt) << "it is told once";
    const auto after_the_end = ends.receive(packet(1, 1));
    ASSERT_FALSE(after_the_end);
    EXPECT_EQ(after_the_end.error().kind, Error::Kind::out_of_order);
    PacketReceiver complete(layout_);
    EXPECT_EQ(gap(complete, packet(1)), std::nullopt);
    EXPECT_EQ(complete.finish(at(5ms), 1), std::nullopt);
    EXPECT_EQ(complete.finish(at(5ms) + 1ns, 1), (TimeSpan{at(5ms), at(10ms)}));
    EXPECT_EQ(complete.end(), at(10ms));
}

TEST_F(HandMadePackets, LackAPartFirstOrInTheMiddle) {
    PacketReceiver first(layout_);
    EXPECT_EQ(gap(first, packet(1)), std::nullopt);
    EXPECT_EQ(gap(first, packet(2, 1, true)), (TimeSpan{at(5ms), at(10ms)}));
    EXPECT_EQ(gap(first, packet(2, 3, true)), std::nullopt) << "that span is a gap already";
    EXPECT_EQ(gap(first, packet(3)), std::nullopt);
    PacketReceiver middle(layout_);
    EXPECT_EQ(gap(middle, packet(2, 0, true, 2)), std::nullopt);
    EXPECT_EQ(gap(middle, packet(2, 2, false, 2)), (TimeSpan{at(5ms), at(10ms)}));
    PacketReceiver longer(layout_);
    EXPECT_EQ(gap(longer, packet(2, 1, false, 2)), (TimeSpan{at(5ms), at(10ms)})) << "its silence is known";
    PacketReceiver later(layout_);
    EXPECT_EQ(gap(later, packet(3, 1, false, 2)), (TimeSpan{at(0ms), at(15ms)}));
    PacketReceiver of_the_next(layout_);
    EXPECT_EQ(gap(of_the_next, packet(1, 0, true)), std::nullopt);
    EXPECT_EQ(gap(of_the_next, packet(2, 1)), (TimeSpan{at(0ms), at(10ms)}))
        << "its number is that of the other's";
}

TEST_F(HandMadePackets, ThatAreNotCompleteAreKnownBeforeTheirLastSpan) {
    PacketReceiver goes_on(layout_);
    EXPECT_EQ(gap(goes_on, packet(3, 0, true, 3)), std::nullopt);
    EXPECT_EQ(gap(goes_on, packet(4)), (TimeSpan{at(10ms), at(15ms)}));
    PacketReceiver ends(layout_);
    EXPECT_EQ(gap(ends, packet(3, 0, true, 3)), std::nullopt);
    EXPECT_EQ(ends.finish(at(15ms), 1), (TimeSpan{at(10ms), at(15ms)}));
}

TEST_F(HandMadePackets, SayWhetherPartsAreToCome) {
    PacketReceiver receiver(layout_);
    EXPECT_TRUE(value_or_throw(receiver.receive(packet(1, 0, true))).more);
    EXPECT_FALSE(value_or_throw(receiver.receive(packet(1, 1, false))).more);
}

TEST_F(HandMadePackets, StandAmongThoseOfTheirSession) {
    PacketReceiver receiver(layout_);
    ASSERT_TRUE(receiver.receive(packet(2, 0, true)));
    const auto standing = [&](const proto::Envelope& packet) {
        const auto found = receiver.standing(packet);
        return found ? std::tuple(found->end, found->part, found->misses_some) : std::tuple(-1L, 0U, false);
    };
    EXPECT_EQ(standing(packet(1)), (std::tuple(-1L, 0U, false))) << "older";
    EXPECT_EQ(standing(packet(2)), (std::tuple(-1L, 0U, false))) << "the same";
    EXPECT_EQ(standing(packet(2, 1)), (std::tuple(2L, 1U, false)));
    EXPECT_EQ(standing(packet(2, 2)), (std::tuple(2L, 2U, true))) << "a part is missing";
    EXPECT_EQ(standing(packet(3)), (std::tuple(3L, 0U, true))) << "a part may be missing";
    ASSERT_TRUE(receiver.receive(packet(2, 1)));
    EXPECT_EQ(standing(packet(3)), (std::tuple(3L, 0U, false)));
    EXPECT_EQ(standing(packet(4)), (std::tuple(4L, 0U, true)));
}

TEST_F(HandMadePackets, ThatAreNotUsedAreAGap) {
    PacketReceiver receiver(layout_);
    EXPECT_EQ(gap(receiver, packet(1)), std::nullopt);
    Reception old = value_or_throw(receiver.receive(packet(3)));
    EXPECT_EQ(old.gap, (TimeSpan{at(5ms), at(10ms)}));
    EXPECT_TRUE(old.usable());
    old.stale = true;
    EXPECT_FALSE(old.usable());
    const Reception discarded = receiver.discard(old);
    EXPECT_EQ(discarded.gap, (TimeSpan{at(5ms), at(15ms)}));
    EXPECT_EQ(discarded.known, (TimeSpan{at(15ms), at(15ms)}));
    EXPECT_FALSE(discarded.measured());
    EXPECT_TRUE(discarded.events.empty());
    EXPECT_EQ(receiver.counts().stale, 1U);
    EXPECT_EQ(receiver.counts().events, 1U);
    EXPECT_EQ(receiver.counts().lost_events, 1U);
    EXPECT_EQ(receiver.counts().unknown, 10ms);
    proto::Envelope blind = packet(4);
    blind.set_no_samples_since_ns(1);
    const Reception of_nothing = value_or_throw(receiver.receive(blind));
    EXPECT_TRUE(of_nothing.no_samples);
    EXPECT_FALSE(of_nothing.usable());
    EXPECT_EQ(receiver.discard(of_nothing).gap, (TimeSpan{at(15ms), at(20ms)}));
    EXPECT_EQ(receiver.counts().stale, 1U) << "it was in time";
    EXPECT_EQ(gap(receiver, packet(5)), std::nullopt);
}

TEST_F(HandMadePackets, AreExpectedWhereASessionIsResumed) {
    PacketReceiver receiver(layout_);
    receiver.resume(100, 7);
    EXPECT_EQ(receiver.end(), at(500ms));
    EXPECT_EQ(receiver.counted_events(), 7U);
    const auto older = receiver.receive(packet(99));
    ASSERT_FALSE(older);
    EXPECT_EQ(older.error().kind, Error::Kind::out_of_order);
    // Events may have been lost just before it.
    proto::Envelope next = packet(101);
    next.set_count(9);
    EXPECT_EQ(gap(receiver, next), std::nullopt);
    EXPECT_EQ(receiver.counts().lost_events, 2U);
    next = packet(102);
    next.set_count(11);
    EXPECT_FALSE(receiver.receive(next)) << "no packet is missing";
    EXPECT_EQ(receiver.finish(at(520ms), 12), (TimeSpan{at(505ms), at(520ms)}));
    EXPECT_EQ(receiver.counts().lost_events, 4U) << "12 were sent, 7 and 1 were delivered";
}

// Of 16,383 positions, which wrap, half are ahead.
TEST_F(HandMadePackets, AreAheadUpToHalfOfThePositions) {
    PacketReceiver ahead(layout_);
    EXPECT_EQ(gap(ahead, packet(8191)), (TimeSpan{at(0ms), at(8190 * 5ms)}));
    PacketReceiver behind(layout_);
    const auto older = behind.receive(packet(8192));
    ASSERT_FALSE(older);
    EXPECT_EQ(older.error().kind, Error::Kind::out_of_order);
}

// 2^62 ns, in spans of 5 ms.
TEST_F(HandMadePackets, BeginWithin146Years) {
    constexpr std::uint64_t last = 922'337'203'685;
    const auto beginning_at = [&](std::uint64_t begin) {
        proto::Envelope far = packet(static_cast<std::uint32_t>((begin + 1) % 16'383));
        far.set_begin(begin);
        return far;
    };
    PacketReceiver receiver(layout_);
    const auto later = receiver.receive(beginning_at(last + 1));
    ASSERT_FALSE(later);
    EXPECT_EQ(later.error().text, "packet: begins at an impossible time");
    EXPECT_TRUE(receiver.receive(beginning_at(last)));
    EXPECT_EQ(receiver.position(), last + 1);
    PacketReceiver resumed(layout_);
    resumed.resume(~std::uint64_t{0}, 0);
    EXPECT_EQ(resumed.position(), last);
}

TEST_F(HandMadePackets, StampedLaterThanCanBeAreRefused) {
    PacketReceiver receiver(layout_);
    const auto late = receiver.receive(packet(3), at(13ms));
    ASSERT_FALSE(late);
    EXPECT_EQ(late.error().kind, Error::Kind::malformed);
    EXPECT_EQ(late.error().text, "packet: is stamped 2 ms later than can be");
    EXPECT_EQ(receiver.counts().refused, 1U);
    EXPECT_TRUE(receiver.receive(packet(3), at(15ms)));
}

TEST(Packets, SurviveEveryChangedBit) {
    std::mt19937_64 random(8);
    PacketLayout layout = layout_of(9);
    layout.max_events = 20;
    const auto packets = packets_of(layout, random_events(random, layout, 1000, 500ms), at(600ms));
    for (const auto& packet : packets) {
        const std::string body = packet.SerializeAsString();
        for (std::size_t bit = 0; bit < body.size() * 8; ++bit) {
            std::string changed = body;
            changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << (bit % 8)));
            proto::Envelope read;
            if (!read.ParseFromString(changed)) continue;
            PacketReceiver receiver(layout);
            const Result<Reception> reception = receiver.receive(read);
            if (!reception) continue;
            for (const Event& event : reception.value().events) {
                EXPECT_LT(event.address, 9U);
                EXPECT_GE(event.time, reception.value().known.begin);
                EXPECT_LT(event.time, reception.value().known.end);
            }
        }
    }
}

// A receiver ignores `acknowledged` and `tolerance` where spikes are not predicted.
TEST(PacketReceiver, AcknowledgesAndPresumesNothingUnlessSpikesArePredicted) {
    for (const bool acknowledged : {true, false}) {
        PacketLayout layout{.addresses = 9};
        Packetizer packetizer(layout);
        layout.acknowledged = acknowledged;
        layout.tolerance = layout.tick;
        PacketReceiver receiver(layout);
        int packets = 0;
        packetizer.push(std::vector<Event>{{scene_start + 1ms, 3}});
        packetizer.close(scene_start + 5ms, [&](const proto::Envelope& packet) {
            const auto reception = receiver.receive(packet);
            ASSERT_TRUE(reception) << reception.error().text;
            EXPECT_EQ(reception.value().presumed_until, reception.value().known.end);
            proto::Envelope message;
            EXPECT_FALSE(receiver.acknowledge(message));
            ++packets;
        });
        EXPECT_EQ(packets, 1);
    }
}

}  // namespace
}  // namespace afferent
