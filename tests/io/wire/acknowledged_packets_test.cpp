// Packets that refer to what the other end has acknowledged, on links that lose them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <random>

#include "afferent/io/wire/frame.hpp"
#include "tests/io/wire/packet_streams.hpp"
#include "tests/io/wire/wandering_trains.hpp"

namespace afferent {
namespace {

PacketLayout acknowledged(Address addresses, Duration tolerance = 0us) {
    PacketLayout layout = predicted(addresses, tolerance);
    layout.acknowledged = true;
    return layout;
}

// One direction: each packet or acknowledgement takes some spans, or is lost; some come twice, or late.
template <class Message>
class Way {
  public:
    struct Faults {
        double loss = 0;
        double twice = 0;
        double late = 0;
        int spans = 1;
    };

    Way(const Faults& faults, std::uint64_t seed) : faults_(faults), random_(seed) {}

    void send(std::int64_t now, const Message& message) {
        if (happens(faults_.loss)) return;
        const int times = happens(faults_.twice) ? 2 : 1;
        for (int i = 0; i < times; ++i)
            flying_.push_back({now + faults_.spans + (happens(faults_.late) ? 3 : 0), message});
    }

    template <class Take>
    void arrive(std::int64_t now, const Take& take) {
        for (std::size_t i = 0; i < flying_.size();) {
            if (flying_[i].first > now) {
                ++i;
                continue;
            }
            const Message message = flying_[i].second;
            flying_.erase(flying_.begin() + static_cast<std::ptrdiff_t>(i));
            take(message);
        }
    }

    void lose_all() { flying_.clear(); }

  private:
    bool happens(double probability) { return std::bernoulli_distribution(probability)(random_); }

    Faults faults_;
    std::mt19937_64 random_;
    std::deque<std::pair<std::int64_t, Message>> flying_;
};

using Packets = Way<proto::Envelope>;
using Acknowledgements = Way<proto::Acknowledgement>;

// A coprocessor and a hand in virtual time, span by span.
class Ends {
  public:
    Ends(const PacketLayout& layout, const Packets::Faults& there, const Acknowledgements::Faults& back,
         std::uint64_t seed)
        : layout_(layout),
          packetizer_(layout),
          receiver_(layout),
          there_(there, seed),
          back_(back, seed + 1) {}

    void pass(std::span<const Code> codes) {
        events_.clear();
        for (const Code code : codes)
            events_.push_back({scene_start + span_ * layout_.span + code / layout_.addresses * layout_.tick,
                               code % layout_.addresses});
        packetizer_.push(events_);
        fired_.insert(fired_.end(), events_.begin(), events_.end());
        ++span_;
        back_.arrive(span_, [&](const proto::Acknowledgement& acknowledgement) {
            EXPECT_TRUE(packetizer_.acknowledge(acknowledgement));
        });
        packetizer_.close(scene_start + span_ * layout_.span,
                          [&](const proto::Envelope& packet) { send(packet); });
        there_.arrive(span_, [&](const proto::Envelope& packet) { receive(packet); });
    }

    void send(const proto::Envelope& packet) {
        ++sent_;
        bytes_ += writer_.datagram(packet).size();
        there_.send(span_, packet);
    }

    void receive(const proto::Envelope& packet) {
        const auto reception = receiver_.receive(packet);
        if (reception) {
            take(received_, reception.value());
        } else {
            EXPECT_EQ(reception.error().kind, Error::Kind::out_of_order) << reception.error().text;
        }
        if (receiver_.acknowledge(answer_)) back_.send(span_, answer_.acknowledgement());
    }

    // The coprocessor goes on in a new session; so does the hand, from where it was.
    void start_again() {
        there_.lose_all();
        back_.lose_all();
        packetizer_ = Packetizer(layout_);
        packetizer_.begin_at(scene_start + span_ * layout_.span);
        end_session();
        const std::uint64_t position = receiver_.position();
        receiver_ = PacketReceiver(layout_);
        receiver_.resume(position, 0);
    }

    // The rest of a packet of which a part has come is lost.
    void end_session() {
        if (const auto gap = receiver_.finish(receiver_.end(), 0)) received_.gaps.push_back(*gap);
    }

    // How many events of known spans are not told, or further off than the tolerance.
    std::size_t wrong() const {
        std::vector<std::vector<TimePoint>> told(layout_.addresses);
        for (const Event& event : received_.events) told[event.address].push_back(event.time);
        std::vector<std::vector<TimePoint>> fired(layout_.addresses);
        for (const Event& event : fired_) fired[event.address].push_back(event.time);
        std::size_t found = 0;
        for (Address address = 0; address < layout_.addresses; ++address) {
            std::ranges::sort(told[address]);
            // An event near the edge of a gap may be told on its other side, or be lost there.
            for (const TimePoint time : fired[address])
                if (is_known(time) && !has_near(told[address], time)) ++found;
            for (const TimePoint time : told[address])
                if (!has_near(fired[address], time)) ++found;
        }
        return found;
    }

    const PacketLayout layout_;
    Packetizer packetizer_;
    PacketReceiver receiver_;
    Packets there_;
    Acknowledgements back_;
    Received received_;
    std::vector<Event> fired_;
    std::size_t bytes_ = 0;
    std::size_t sent_ = 0;

  private:
    bool has_near(const std::vector<TimePoint>& times, TimePoint time) const {
        const auto found = std::ranges::lower_bound(times, time - layout_.tolerance);
        return found != times.end() && *found <= time + layout_.tolerance;
    }
    // A gap may lie in what was known in part.
    bool is_known(TimePoint time) const {
        const TimeSpan* const known = last_from(received_.known, time);
        const TimeSpan* const gap = last_from(received_.gaps, time + layout_.tolerance);
        return known && time + layout_.tolerance < known->end && time - layout_.tolerance >= known->begin &&
               (!gap || gap->end <= time - layout_.tolerance);
    }
    // Of those that begin at or before the time.
    static const TimeSpan* last_from(const std::vector<TimeSpan>& spans, TimePoint time) {
        const auto after = std::ranges::upper_bound(spans, time, {}, &TimeSpan::begin);
        return after == spans.begin() ? nullptr : &*std::prev(after);
    }

    std::int64_t span_ = 0;
    proto::Envelope answer_;
    FrameWriter writer_;
    std::vector<Event> events_;
};

Duration covered(const std::vector<TimeSpan>& spans) {
    Duration sum{};
    for (const TimeSpan& span : spans) sum += span.end - span.begin;
    return sum;
}

TEST(AcknowledgedPackets, BringEveryEventToItsTickWhereNothingIsLost) {
    const PacketLayout layout = acknowledged(20);
    Ends ends(layout, {.spans = 1}, {.spans = 1}, 1);
    for (const auto& codes : wandering(layout, 2'000, 1)) ends.pass(codes);
    for (int i = 0; i < 10; ++i) ends.pass({});
    EXPECT_EQ(ends.received_.events, on_ticks(ends.fired_, layout.tick));
    EXPECT_TRUE(ends.received_.gaps.empty());
    EXPECT_EQ(ends.receiver_.counts().refused, 0U);
}

TEST(AcknowledgedPackets, TakeFewerBytesTheSoonerTheyAreAcknowledged) {
    const PacketLayout layout = acknowledged(20, 500us);
    const Spans spans = wandering(layout, 4'000, 2);
    std::vector<std::size_t> bytes;
    for (const int delay : {1, 6, 30}) {
        Ends ends(layout, {.spans = 1}, {.spans = delay}, 2);
        for (const auto& codes : spans) ends.pass(codes);
        EXPECT_EQ(ends.wrong(), 0U);
        bytes.push_back(ends.bytes_);
    }
    EXPECT_LT(bytes[0], bytes[1]);
    EXPECT_LT(bytes[1], bytes[2]);
    // Without any, each packet tells all that it has.
    Ends alone(layout, {}, {.loss = 1}, 2);
    for (const auto& codes : spans) alone.pass(codes);
    EXPECT_LT(bytes[2], alone.bytes_);
    EXPECT_EQ(alone.wrong(), 0U);
}

TEST(AcknowledgedPackets, CostTheirOwnTimeAloneWhereTheyAreLost) {
    for (const Duration tolerance : {Duration(0us), Duration(500us), Duration(1ms)}) {
        const PacketLayout layout = acknowledged(20, tolerance);
        Ends ends(layout, {.loss = 0.1, .twice = 0.01, .late = 0.05, .spans = 2}, {.loss = 0.1, .late = 0.05},
                  3);
        for (const auto& codes : wandering(layout, 6'000, 3)) ends.pass(codes);
        EXPECT_EQ(ends.wrong(), 0U);
        EXPECT_EQ(ends.receiver_.counts().refused, 0U);
        EXPECT_FALSE(ends.received_.gaps.empty());
        EXPECT_GT(ends.receiver_.counts().out_of_order, 0U);
        // What is not known is a gap, and nothing is both.
        const Duration known = covered(ends.received_.known);
        EXPECT_EQ(known + covered(ends.received_.gaps), ends.receiver_.end() - scene_start);
        // A packet that is overtaken is lost, and each covers a span or a heartbeat.
        EXPECT_LT(covered(ends.received_.gaps), 30s * 3 / 10);
    }
}

// AFFERENT_SOAK_EVENTS=100000000 for a night.
std::uint64_t events_to_send() {
    const char* wanted = std::getenv("AFFERENT_SOAK_EVENTS");
    return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 100'000;
}

TEST(AcknowledgedPackets, GoOnAfterEitherEndHasStartedAgain) {
    const std::array<Duration, 3> tolerances{0us, 500us, 2ms};
    std::uint64_t sent = 0;
    for (std::uint64_t seed = 0; sent < events_to_send(); ++seed) {
        PacketLayout layout = acknowledged(20, tolerances[seed % tolerances.size()]);
        if (seed % 2 == 1) layout.max_events = 4;  // so that there are parts
        Ends ends(layout, {.loss = 0.1, .twice = 0.01, .late = 0.05},
                  {.loss = 0.1, .late = 0.05, .spans = 1 + static_cast<int>(seed % 5)}, seed);
        const Spans spans = wandering(layout, 6'000, seed);
        for (std::size_t i = 0; i < spans.size(); ++i) {
            if (i % 500 == 250) ends.start_again();
            ends.pass(spans[i]);
        }
        ends.end_session();
        ASSERT_EQ(ends.wrong(), 0U) << "seed " << seed;
        ASSERT_EQ(ends.receiver_.counts().refused, 0U) << "seed " << seed;
        EXPECT_GT(covered(ends.received_.known), 20s);
        sent += ends.fired_.size();
    }
}

TEST(AcknowledgedPackets, MendWhatIsForeseenOtherwise) {
    // The hand has another law than it should: what it decodes is wrong, which the next check says.
    const PacketLayout layout = acknowledged(20);
    PacketLayout other = layout;
    other.neurons[0].law.tau_m_ms = 12;
    Packetizer packetizer(layout);
    PacketReceiver receiver(other);
    std::vector<proto::Envelope> packets;
    proto::Envelope answer;
    std::uint64_t asked = 0;
    TimePoint begin = scene_start;
    std::vector<Event> events;
    for (const auto& codes : wandering(layout, 1'000, 5)) {
        events.clear();
        for (const Code code : codes) events.push_back({begin + code / 20 * layout.tick, code % 20});
        packetizer.push(events);
        begin += layout.span;
        packets.clear();
        packetizer.close(begin, [&](const proto::Envelope& packet) { packets.push_back(packet); });
        for (const proto::Envelope& packet : packets) {
            const bool refused = !receiver.receive(packet);
            if (!receiver.acknowledge(answer)) continue;
            const proto::Acknowledgement& acknowledgement = answer.acknowledgement();
            if (refused) {
                EXPECT_EQ(acknowledgement.position(), 0U);
            }
            if (acknowledgement.position() == 0) ++asked;
            EXPECT_TRUE(packetizer.acknowledge(acknowledgement));
        }
    }
    EXPECT_GT(receiver.counts().refused, 10U) << "a check comes with about every 16th packet";
    // Each time the packet after that is the first of another begin.
    EXPECT_LE(asked, 2 * receiver.counts().refused);
    EXPECT_GT(receiver.counts().packets, 5 * receiver.counts().refused);
}

TEST(AcknowledgedPackets, MendWhatAHandClaimsToHaveReceived) {
    const PacketLayout layout = acknowledged(20);
    Packetizer packetizer(layout);
    PacketReceiver receiver(layout);
    std::vector<proto::Envelope> packets;
    proto::Envelope answer;
    std::mt19937_64 random(8);
    TimePoint begin = scene_start;
    std::vector<Event> events;
    for (const auto& codes : wandering(layout, 4'000, 8)) {
        events.clear();
        for (const Code code : codes) events.push_back({begin + code / 20 * layout.tick, code % 20});
        packetizer.push(events);
        begin += layout.span;
        packets.clear();
        packetizer.close(begin, [&](const proto::Envelope& packet) { packets.push_back(packet); });
        for (const proto::Envelope& packet : packets) {
            if (random() % 10 == 0) continue;
            (void)receiver.receive(packet);
            if (!receiver.acknowledge(answer)) continue;
            // It says that it has all of it, whatever was lost.
            proto::Acknowledgement claim = answer.acknowledgement();
            std::uint32_t all = 0;
            for (const std::uint32_t count : claim.spans()) all += count;
            claim.clear_spans();
            claim.add_spans(all);
            EXPECT_TRUE(packetizer.acknowledge(claim));
        }
    }
    // The checks say so, and in between most packets are read.
    EXPECT_GT(receiver.counts().refused, 10U);
    EXPECT_GT(receiver.counts().packets, 5 * receiver.counts().refused);
    EXPECT_GT(receiver.end(), begin - 100ms);
}

// Its further parts may be read, but the packet as a whole is not known, and is not acknowledged.
TEST(AcknowledgedPackets, WithoutTheirFirstPartAreNotKnown) {
    PacketLayout layout = acknowledged(20);
    layout.max_events = 7;
    std::vector<Event> events{{at(1ms), 3}};
    for (Address address = 0; address < 20; ++address) events.push_back({at(7ms), address});
    const auto packets = packets_of(layout, events, at(10ms));
    ASSERT_EQ(packets.size(), 4U);
    ASSERT_EQ(packets.back().part(), 2U);
    for (const bool has_first : {true, false}) {
        PacketReceiver receiver(layout);
        for (const proto::Envelope& packet : packets) {
            if (!has_first && packet.more() && packet.part() == 0) continue;
            EXPECT_TRUE(receiver.receive(packet));
        }
        proto::Envelope answer;
        ASSERT_TRUE(receiver.acknowledge(answer));
        // So many spans before the end are known, so many before those are not, and so on.
        const auto& spans = answer.acknowledgement().spans();
        EXPECT_EQ(std::vector<std::uint32_t>(spans.begin(), spans.end()),
                  has_first ? std::vector<std::uint32_t>{2} : (std::vector<std::uint32_t>{0, 1, 1}));
    }
}

TEST(AcknowledgedPackets, AreSilentAtRest) {
    const PacketLayout layout = acknowledged(20, 500us);
    Ends ends(layout, {}, {}, 6);
    for (const auto& codes : wandering(layout, 400, 6)) ends.pass(codes);
    for (int i = 0; i < 400; ++i) ends.pass({});
    const std::size_t sent = ends.sent_;
    const std::size_t bytes = ends.bytes_;
    for (int i = 0; i < 20'000; ++i) ends.pass({});
    EXPECT_EQ(ends.sent_ - sent, 4'000U) << "heartbeats";
    EXPECT_LT(ends.bytes_ - bytes, 4'000U * 10);
    EXPECT_TRUE(ends.received_.gaps.empty());
    EXPECT_EQ(ends.receiver_.counts().refused, 0U);
}

TEST(AcknowledgedPackets, RefuseAnAcknowledgementThatCannotBe) {
    const PacketLayout layout = acknowledged(20);
    Packetizer packetizer(layout);
    packetizer.finish(at(50ms), [](const proto::Envelope&) {});
    proto::Acknowledgement acknowledgement;
    acknowledgement.set_position(10 + 1);
    EXPECT_TRUE(packetizer.acknowledge(acknowledgement));
    acknowledgement.set_position(11 + 1);
    EXPECT_FALSE(packetizer.acknowledge(acknowledgement)) << "nothing has been sent of that";
    acknowledgement.set_position(position_modulus + 1);
    EXPECT_FALSE(packetizer.acknowledge(acknowledgement));
    acknowledgement.set_position(9 + 1);
    EXPECT_TRUE(packetizer.acknowledge(acknowledgement)) << "it has been overtaken";
    Packetizer in_order(predicted(20));
    EXPECT_FALSE(in_order.acknowledge(acknowledgement)) << "nobody asks for it";
}

TEST(AcknowledgedPackets, RefuseAReferenceThatCannotBe) {
    const PacketLayout layout = acknowledged(20);
    const auto packet_with = [](std::string payload) {
        proto::Envelope packet;
        packet.set_position(100 + 1);
        packet.set_payload(std::move(payload));
        return packet;
    };
    const auto refusal = [&](const std::string& payload) {
        PacketReceiver receiver(layout);
        const auto reception = receiver.receive(packet_with(payload));
        return reception ? "" : reception.error().text;
    };
    EXPECT_EQ(refusal(std::string(1, '\x80')), "packet: does not say what it refers to");
    // 2 · 100 + 1: an origin 100 spans before the begin of the span that ends at 100.
    EXPECT_EQ(refusal("\xc9\x01"), "packet: refers to what is too long ago");
    EXPECT_EQ(refusal("\xc7\x01"), "");
    // 2 · 99 and no origin: the begin of the scene, of which nothing is known.
    EXPECT_EQ(refusal("\xc6\x01"), "");
}

TEST(AcknowledgedPackets, NameTheirReferenceInAByteWhereItIsNear) {
    std::string payload;
    append_name({63, false}, payload);
    EXPECT_EQ(payload, "\x7e");
    payload.clear();
    append_name({63, true}, payload);
    EXPECT_EQ(payload, "\x7f");
    payload.clear();
    append_name({64, true}, payload);
    payload += "rest";
    auto bytes = std::as_bytes(std::span(std::as_const(payload)));
    EXPECT_EQ(take_name(bytes), (ReferenceName{64, true}));
    EXPECT_EQ(bytes.size(), 4U);
}

}  // namespace
}  // namespace afferent
