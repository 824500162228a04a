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

// Gives the sink each packet of these spans, from `begin` on. It may acknowledge them.
template <class Sink>
void send_all(Packetizer& packetizer, const Spans& spans, const Sink& sink, TimePoint begin = scene_start) {
    const PacketLayout& layout = packetizer.layout();
    std::vector<Event> events;
    std::vector<proto::Envelope> packets;
    for (const auto& codes : spans) {
        events.clear();
        for (const Code code : codes)
            events.push_back({begin + code / layout.addresses * layout.tick, code % layout.addresses});
        packetizer.push(events);
        begin += layout.span;
        packets.clear();
        packetizer.close(begin, [&](const proto::Envelope& packet) { packets.push_back(packet); });
        for (const proto::Envelope& packet : packets) sink(packet);
    }
}

// What the receiver acknowledges now; nothing where nothing is due.
std::optional<proto::Acknowledgement> acknowledged_by(PacketReceiver& receiver) {
    proto::Envelope answer;
    if (!receiver.acknowledge(answer)) return std::nullopt;
    return answer.acknowledgement();
}

// So many spans before the end are known, so many before those are not, and so on.
std::vector<std::uint32_t> known_and_not(const std::optional<proto::Acknowledgement>& acknowledgement) {
    if (!acknowledgement || acknowledgement->position() == 0) return {};
    return {acknowledgement->spans().begin(), acknowledgement->spans().end()};
}

bool asks_for_a_new_begin(const std::optional<proto::Acknowledgement>& acknowledgement) {
    return acknowledgement && acknowledgement->position() == 0;
}

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
    std::uint64_t asked = 0;
    send_all(packetizer, wandering(layout, 1'000, 5), [&](const proto::Envelope& packet) {
        const bool refused = !receiver.receive(packet);
        const auto acknowledgement = acknowledged_by(receiver);
        if (!acknowledgement) return;
        if (refused) {
            EXPECT_TRUE(asks_for_a_new_begin(acknowledgement));
        }
        if (asks_for_a_new_begin(acknowledgement)) ++asked;
        EXPECT_TRUE(packetizer.acknowledge(*acknowledgement));
    });
    EXPECT_GT(receiver.counts().refused, 10U) << "a check comes with about every 16th packet";
    // Each time the packet after that is the first of another begin.
    EXPECT_LE(asked, 2 * receiver.counts().refused);
    EXPECT_GT(receiver.counts().packets, 5 * receiver.counts().refused);
}

TEST(AcknowledgedPackets, MendWhatAHandClaimsToHaveReceived) {
    const PacketLayout layout = acknowledged(20);
    Packetizer packetizer(layout);
    PacketReceiver receiver(layout);
    std::mt19937_64 random(8);
    send_all(packetizer, wandering(layout, 4'000, 8), [&](const proto::Envelope& packet) {
        if (random() % 10 == 0) return;
        (void)receiver.receive(packet);
        auto claim = acknowledged_by(receiver);
        if (!claim) return;
        // It says that it has all of it, whatever was lost.
        std::uint32_t all = 0;
        for (const std::uint32_t count : claim->spans()) all += count;
        claim->clear_spans();
        claim->add_spans(all);
        EXPECT_TRUE(packetizer.acknowledge(*claim));
    });
    // The checks say so, and in between most packets are read.
    EXPECT_GT(receiver.counts().refused, 10U);
    EXPECT_GT(receiver.counts().packets, 5 * receiver.counts().refused);
    EXPECT_GT(receiver.end(), at(20s - 100ms));
}

// Its other parts may be read, but the packet as a whole is not known, and is not acknowledged.
TEST(AcknowledgedPackets, WithoutOneOfTheirPartsAreNotKnown) {
    PacketLayout layout = acknowledged(20);
    layout.max_events = 7;
    std::vector<Event> events{{at(1001ms), 3}};
    for (Address address = 0; address < 20; ++address) events.push_back({at(1007ms), address});
    events.push_back({at(1014ms), 5});
    Packetizer packetizer(layout);
    packetizer.begin_at(at(1s));
    packetizer.push(events);
    std::vector<proto::Envelope> packets;
    packetizer.finish(at(1015ms), [&](const proto::Envelope& packet) { packets.push_back(packet); });
    ASSERT_EQ(packets.size(), 5U);
    ASSERT_EQ(packets[3].part(), 2U);
    const auto without = [&](std::size_t lost, std::size_t first = 0) {
        PacketReceiver receiver(layout);
        receiver.resume(200, 0);
        for (std::size_t i = first; i < packets.size(); ++i)
            if (i != lost) {
                EXPECT_TRUE(receiver.receive(packets[i]));
            }
        return known_and_not(acknowledged_by(receiver));
    };
    using Counts = std::vector<std::uint32_t>;
    EXPECT_EQ(without(5), Counts{3});
    EXPECT_EQ(without(0), (Counts{2, 1}));
    for (const std::size_t part : {1, 2, 3}) EXPECT_EQ(without(part), (Counts{1, 1, 1})) << part;
    // The first that comes at all is known in part.
    EXPECT_EQ(without(2, 1), (Counts{1, 2}));
    EXPECT_EQ(without(3, 1), (Counts{1, 2}));
    // A packet is acknowledged once all of its parts have come.
    PacketReceiver receiver(layout);
    receiver.resume(200, 0);
    for (std::size_t i = 0; i < packets.size(); ++i) {
        EXPECT_TRUE(receiver.receive(packets[i]));
        EXPECT_EQ(acknowledged_by(receiver).has_value(), !packets[i].more()) << i;
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

// A packet of one span, without any event.
proto::Envelope span_told_from(const ReferenceName& name, std::uint64_t begin) {
    proto::Envelope packet;
    packet.set_position(static_cast<std::uint32_t>((begin + 1) % position_modulus) + 1);
    packet.set_begin(begin);
    append_name(name, *packet.mutable_payload());
    return packet;
}

// A heartbeat of five spans.
proto::Envelope silence_until(std::uint64_t end) {
    proto::Envelope packet;
    packet.set_position(static_cast<std::uint32_t>(end % position_modulus) + 1);
    packet.set_begin(end - 5);
    return packet;
}

TEST(AcknowledgedPackets, RefuseAReferenceThatCannotBe) {
    const auto refusal = [](PacketReceiver& receiver, const proto::Envelope& packet) {
        const auto reception = receiver.receive(packet);
        return reception ? "" : reception.error().text;
    };
    const auto refused_at = [&](std::uint64_t resumed, const proto::Envelope& packet) {
        PacketReceiver receiver(acknowledged(20));
        receiver.resume(resumed, 0);
        return refusal(receiver, packet);
    };
    for (const std::uint64_t resumed : {0, 10}) {
        proto::Envelope nameless = span_told_from({}, 99);
        nameless.set_payload(std::string(1, '\x80'));
        EXPECT_EQ(refused_at(resumed, nameless), "packet: does not say what it refers to");
    }
    EXPECT_EQ(refused_at(0, span_told_from({100, true}, 99)), "packet: refers to what is too long ago");
    EXPECT_EQ(refused_at(0, span_told_from({99, true}, 99)), "");
    EXPECT_EQ(refused_at(0, span_told_from({99, false}, 99)), "") << "the begin of the scene";
    EXPECT_EQ(refused_at(5000, span_told_from({2048, true}, 5000)), "");
    EXPECT_EQ(refused_at(5000, span_told_from({2049, true}, 5000)), "packet: refers to what is too long ago");

    // The sender has referred to a later one before.
    PacketReceiver receiver(acknowledged(20));
    EXPECT_EQ(refusal(receiver, span_told_from({0, true}, 0)), "");
    EXPECT_EQ(refusal(receiver, span_told_from({0, false}, 1)), "");
    EXPECT_EQ(refusal(receiver, span_told_from({2, false}, 2)),
              "packet: refers to what has not been received");
}

TEST(AcknowledgedPackets, RefuseACheckOfAnotherBegin) {
    const PacketLayout layout = acknowledged(20);
    for (const bool is_right : {true, false}) {
        Packetizer packetizer(layout);
        PacketReceiver receiver(layout);
        std::vector<std::string> refusals;
        send_all(packetizer, wandering(layout, 100, 5), [&](proto::Envelope packet) {
            if (packet.has_check() && !is_right) packet.set_check((packet.check() + 1) % check_modulus);
            const auto reception = receiver.receive(packet);
            EXPECT_EQ(reception.has_value(), is_right || !packet.has_check());
            if (!reception) {
                EXPECT_EQ(reception.error().text, "packet: was foreseen otherwise by its sender");
            }
            if (const auto acknowledgement = acknowledged_by(receiver))
                packetizer.acknowledge(*acknowledgement);
        });
    }
}

// What was told before it refers to a begin that the sender may have given up.
TEST(AcknowledgedPackets, AfterOneThatCannotBeReadAreKnownAlone) {
    PacketReceiver receiver(acknowledged(20));
    for (const std::uint32_t begin : {0U, 1U, 2U})
        ASSERT_TRUE(receiver.receive(span_told_from({begin, true}, begin)));
    EXPECT_FALSE(acknowledged_by(receiver)) << "they tell of no events";
    proto::Envelope unreadable = span_told_from({3, true}, 3);
    unreadable.mutable_payload()->append(40, '\xff');
    ASSERT_FALSE(receiver.receive(unreadable));
    EXPECT_TRUE(asks_for_a_new_begin(acknowledged_by(receiver)));
    std::string event_at_once;
    Packetizer packetizer(acknowledged(20));
    packetizer.push(std::vector<Event>{{at(0s), 7}});
    packetizer.close(at(5ms),
                     [&](const proto::Envelope& packet) { event_at_once = packet.payload().substr(1); });
    proto::Envelope again = span_told_from({4, true}, 4);
    again.mutable_payload()->append(event_at_once);
    ASSERT_TRUE(receiver.receive(again));
    EXPECT_EQ(known_and_not(acknowledged_by(receiver)), (std::vector<std::uint32_t>{1, 4}));
}

// The receiver does not record the spans in between. It asks the sender to begin anew.
TEST(AcknowledgedPackets, FarAheadTakeNoMemory) {
    constexpr std::uint64_t far = std::uint64_t{1} << 38;
    PacketReceiver silent(acknowledged(20));
    EXPECT_TRUE(silent.receive(silence_until(far)));
    EXPECT_TRUE(asks_for_a_new_begin(acknowledged_by(silent)));
    PacketReceiver refers(acknowledged(20));
    const auto refused = refers.receive(span_told_from({0, false}, far));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().text, "packet: refers to what has not been received");
    EXPECT_TRUE(asks_for_a_new_begin(acknowledged_by(refers)));
    const auto begun = refers.receive(span_told_from({0, true}, far));
    ASSERT_TRUE(begun);
    EXPECT_TRUE(begun.value().measured());
}

TEST(AcknowledgedPackets, AskForANewBeginWhereTheLastIsTooOld) {
    PacketReceiver receiver(acknowledged(20));
    for (std::uint64_t end = 5; end <= 2045; end += 5) {
        ASSERT_TRUE(receiver.receive(silence_until(end)));
        EXPECT_FALSE(asks_for_a_new_begin(acknowledged_by(receiver))) << end;
    }
    ASSERT_TRUE(receiver.receive(silence_until(2050)));
    EXPECT_TRUE(asks_for_a_new_begin(acknowledged_by(receiver)));
}

// A hand that resumes can read silence, but nothing that refers to what came before.
TEST(AcknowledgedPackets, OfAnEarlierHandAreGapsUntilTheirSenderBeginsAnew) {
    PacketReceiver silent(acknowledged(20));
    silent.resume(1000, 0);
    for (const std::uint64_t end : {1005, 1010}) {
        const auto reception = silent.receive(silence_until(end));
        ASSERT_TRUE(reception);
        EXPECT_TRUE(reception.value().measured());
        EXPECT_FALSE(reception.value().gap);
        EXPECT_TRUE(asks_for_a_new_begin(acknowledged_by(silent)));
    }

    // What the further part of such a packet says is not read as a name.
    proto::Envelope part = span_told_from({1, false}, 1010);
    for (const std::uint32_t number : {0, 1}) {
        part.set_part(number);
        part.set_more(number == 0);
        const auto reception = silent.receive(part);
        ASSERT_TRUE(reception);
        EXPECT_FALSE(reception.value().measured());
        part.clear_payload();
        append_name({0, true}, *part.mutable_payload());
    }

    PacketLayout layout = acknowledged(20);
    layout.max_events = 4;
    const Spans spans = wandering(layout, 400, 11);
    Packetizer packetizer(layout);
    PacketReceiver earlier(layout);
    send_all(packetizer, Spans(spans.begin(), spans.begin() + 200), [&](const proto::Envelope& packet) {
        EXPECT_TRUE(earlier.receive(packet));
        if (const auto acknowledgement = acknowledged_by(earlier)) packetizer.acknowledge(*acknowledgement);
    });
    PacketReceiver resumed(layout);
    resumed.resume(earlier.position(), earlier.counted_events());
    std::uint64_t further_parts = 0;
    bool begun = false;
    send_all(
        packetizer, Spans(spans.begin() + 200, spans.end()),
        [&](const proto::Envelope& packet) {
            auto payload = std::as_bytes(std::span(packet.payload()));
            if (packet.part() == 0 && take_name(payload).value().is_origin) begun = true;
            const auto reception = resumed.receive(packet);
            ASSERT_TRUE(reception) << reception.error().text;
            EXPECT_EQ(reception.value().measured(), begun);
            EXPECT_EQ(reception.value().events.empty(), !begun);
            if (!begun && packet.part() > 0) ++further_parts;
            if (!packet.more()) {
                EXPECT_EQ(asks_for_a_new_begin(acknowledged_by(resumed)), !begun);
            }
        },
        at(1s));
    EXPECT_GT(further_parts, 0U);
    EXPECT_TRUE(begun);
}

TEST(AcknowledgedPackets, StayInStepInSilenceAndAfterAFrameThatCannotBeRead) {
    const PacketLayout layout = acknowledged(20);
    Packetizer packetizer(layout);
    PacketReceiver receiver(layout);
    std::uint64_t heartbeats = 0;
    std::uint64_t heartbeats_acknowledged = 0;
    const auto pass = [&](const proto::Envelope& packet) {
        const auto reception = receiver.receive(packet);
        ASSERT_TRUE(reception);
        EXPECT_TRUE(reception.value().measured());
        const auto acknowledgement = acknowledged_by(receiver);
        EXPECT_FALSE(asks_for_a_new_begin(acknowledgement));
        if (packet.payload().empty()) {
            ++heartbeats;
            if (acknowledgement) ++heartbeats_acknowledged;
        }
        if (acknowledgement) packetizer.acknowledge(*acknowledgement);
        receiver.lose_frame();
    };
    Spans spans = wandering(layout, 100, 12);
    spans.resize(140);
    send_all(packetizer, spans, pass);
    EXPECT_GT(heartbeats, 5U);
    EXPECT_EQ(heartbeats_acknowledged, 0U);
    send_all(packetizer, wandering(layout, 100, 13), pass, at(700ms));
    // Long silence is acknowledged until the sender refers to it, and so can forget what was before.
    heartbeats_acknowledged = 0;
    send_all(packetizer, Spans(600), pass, at(1200ms));
    EXPECT_EQ(heartbeats_acknowledged, 2U);
}

TEST(AcknowledgedPackets, AreAcknowledgedWhereTheyTellOfEvents) {
    const PacketLayout layout = acknowledged(2, 2ms);
    Packetizer packetizer(layout);
    PacketReceiver receiver(layout);
    std::uint64_t without_events = 0;
    std::uint64_t with_earlier_events = 0;
    send_all(packetizer, wandering(layout, 4'000, 14), [&](const proto::Envelope& packet) {
        const auto reception = receiver.receive(packet);
        ASSERT_TRUE(reception);
        const std::span<const Event> events = reception.value().events;
        const auto acknowledgement = acknowledged_by(receiver);
        EXPECT_EQ(acknowledgement.has_value(), !events.empty());
        if (events.empty())
            ++without_events;
        else if (events.back().time < receiver.end() - layout.span)
            ++with_earlier_events;
        if (acknowledgement) packetizer.acknowledge(*acknowledgement);
    });
    EXPECT_GT(without_events, 10U);
    EXPECT_GT(with_earlier_events, 10U);
}

TEST(PredictionReference, IsMarkedAsFarBackAsItsOrigin) {
    PredictionReference reference(acknowledged(20));
    const auto described = [&] {
        std::vector<std::uint32_t> counts;
        reference.describe([&](std::uint32_t count) { counts.push_back(count); });
        return counts;
    };
    using Counts = std::vector<std::uint32_t>;
    reference.begin(10);
    for (int i = 0; i < 4; ++i) reference.record({});
    EXPECT_EQ(described(), Counts{4});
    EXPECT_FALSE(reference.mark(14, Counts{1, 4})) << "goes back to 9";
    EXPECT_FALSE(reference.mark(13, Counts{0, 4}));
    EXPECT_EQ(described(), Counts{4});
    EXPECT_TRUE(reference.mark(14, Counts{1, 3}));
    EXPECT_EQ(described(), (Counts{1, 3}));
    EXPECT_TRUE(reference.mark(13, Counts{1, 1, 1}));
    EXPECT_EQ(described(), (Counts{2, 1, 1}));
}

TEST(PredictionReference, IsAnOriginUntilItHasMoved) {
    PredictionReference reference(acknowledged(20));
    reference.begin(10);
    reference.record({});
    reference.move(10);
    EXPECT_TRUE(reference.is_origin());
    reference.move(11);
    EXPECT_FALSE(reference.is_origin());
    EXPECT_EQ(reference.position(), 11);
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
