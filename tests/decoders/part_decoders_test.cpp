// The laws of the decoders of parts, for every decoder of the list.
#include "afferent/decoders/part_decoders.hpp"

#include <gtest/gtest.h>

#include "afferent/decoders/decoders.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

using Part = PartDecoders::Part;

// Part A has the addresses 0 and 3 of six, part B has 2 and 3, and nobody reads the others.
std::vector<Part> two_parts() {
    std::vector<Part> parts{{{.addresses = 6, .largest_grip_n = 10}, 0.25},
                            {{.addresses = 6, .largest_grip_n = 12}, 0.5}};
    parts[0].afferents.add(0, group_with(2), 0.5);
    parts[0].afferents.add(3, group_with(2), 0.5);
    parts[1].afferents.add(2, group_with(4), 0.5);
    parts[1].afferents.add(3, group_with(3), 0.5);
    return parts;
}

// The events of a part, by its own addresses.
std::vector<Event> events_of(const Part& part, std::span<const Event> events) {
    std::vector<Event> own;
    for (const Event& event : events)
        for (std::size_t i = 0; i < part.afferents.afferents.size(); ++i)
            if (part.afferents.afferents[i].address == event.address)
                own.push_back({event.time, static_cast<Address>(i)});
    return own;
}

DecodedAfferents alone(const Part& part) {
    DecodedAfferents own = part.afferents;
    for (std::size_t i = 0; i < own.afferents.size(); ++i) own.afferents[i].address = static_cast<Address>(i);
    own.addresses = own.afferents.size();
    return own;
}

template <class... D>
std::vector<DecoderParameters> all_of(DecoderList<D...>) {
    return {typename D::Parameters{}...};
}
const std::vector<DecoderParameters> every_decoder = all_of(Decoders());

void take_part(PartDecoders& decoders, const Step& step) {
    if (step.lost)
        decoders.lose(step.begin, step.end);
    else
        decoders.observe(step.begin, step.end, step.events);
    decoders.presume_silence(step.presumed);
}

TEST(PartDecoders, EstimateWhatADecoderOfThatPartAloneWould) {
    const auto parts = two_parts();
    for (const DecoderParameters& parameters : every_decoder) {
        PartDecoders decoders(parameters, parts);
        std::vector<GripDecoder> own{{parameters, alone(parts[0])}, {parameters, alone(parts[1])}};
        ASSERT_EQ(decoders.size(), 2U);
        for (const Step& step : random_stream(3, 300, 6)) {
            take_part(decoders, step);
            for (std::size_t i = 0; i < 2; ++i) {
                Step mine = step;
                mine.events = events_of(parts[i], step.events);
                ASSERT_EQ(decoders.estimate(i, step.now), take(own[i], mine)) << parameters.index();
            }
            ASSERT_EQ(decoders.heard_until(), own[0].heard_until());
        }
        EXPECT_EQ(decoders.history(), std::max(own[0].history(), own[1].history()));
    }
}

TEST(PartDecoders, TakeASpanOfMoreEventsThanTheyHaveRoomFor) {
    const auto parts = two_parts();
    std::vector<Event> events;
    for (int i = 0; i < 20'000; ++i)
        events.push_back({scene_start + i * 10us, static_cast<Address>(i % 2 == 0 ? 3 : i % 6)});
    for (const DecoderParameters& parameters : every_decoder) {
        PartDecoders decoders(parameters, parts);
        decoders.observe(scene_start, at(200ms), events);
        for (std::size_t i = 0; i < 2; ++i) {
            GripDecoder own(parameters, alone(parts[i]));
            own.observe(scene_start, at(200ms), events_of(parts[i], events));
            EXPECT_EQ(decoders.estimate(i, at(201ms)), own.estimate(at(201ms))) << parameters.index();
        }
    }
}

TEST(PartDecoders, ContinueFromASnapshotBitForBit) {
    const auto parts = two_parts();
    const auto stream = random_stream(5, 200, 6);
    for (const DecoderParameters& parameters : every_decoder) {
        PartDecoders decoders(parameters, parts);
        PartDecoders other(parameters, parts);
        for (std::size_t i = 0; i < stream.size(); ++i) {
            if (i == 100) other.resume(decoders.snapshot());
            for (PartDecoders* each : {&decoders, &other}) take_part(*each, stream[i]);
            if (i < 100) continue;
            for (std::size_t part = 0; part < 2; ++part)
                ASSERT_EQ(other.estimate(part, stream[i].now), decoders.estimate(part, stream[i].now));
        }
        EXPECT_EQ(other.snapshot(), decoders.snapshot());
        decoders.restart(scene_start);
        EXPECT_EQ(decoders.snapshot(), PartDecoders(parameters, parts).snapshot());
    }
}

TEST(PartDecoders, ContinueWithTheirShareOfTheGripUntilSomethingIsKnown) {
    for (const DecoderParameters& parameters : every_decoder) {
        PartDecoders decoders(parameters, two_parts());
        decoders.resume_after(at(100ms), at(95ms), {8, 0.5, 40});
        EXPECT_EQ(decoders.estimate(0, at(100ms)).force_n, 2);
        EXPECT_EQ(decoders.estimate(1, at(100ms)).force_n, 4);
        decoders.correct({4, 0.5, 40});
        EXPECT_EQ(decoders.estimate(1, at(100ms)).force_n, 2);
    }
}

TEST(PartDecoders, RefuseWhatIsOfOtherPartsAndStayAsTheyWere) {
    PartDecoders decoders(SlidingWindowParameters(), two_parts());
    for (const Step& step : random_stream(3, 20, 6)) take_part(decoders, step);
    const auto before = decoders.snapshot();
    auto mixed = before;
    mixed[1] = PartDecoders(InversionParameters(), two_parts()).snapshot()[1];
    mixed[0] = PartDecoders(SlidingWindowParameters(), two_parts()).snapshot()[0];
    EXPECT_THROW(decoders.resume(mixed), ParameterError);
    EXPECT_THROW(decoders.resume({before[0]}), ParameterError);
    EXPECT_EQ(decoders.snapshot(), before);
    EXPECT_THROW(PartDecoders(SlidingWindowParameters(), {}), ParameterError);
    auto silent = two_parts();
    silent[1].afferents.largest_grip_n = 0.2;
    EXPECT_THROW(PartDecoders(SlidingWindowParameters(), silent), ParameterError);
}

// The cost of a part of a wide stream is that of its own afferents, and eight bytes for each address.
TEST(PartDecoders, TakeMemoryByTheirAfferents) {
    auto wide = two_parts();
    for (Part& part : wide) part.afferents.addresses = 100'000;
    const PartDecoders narrow(FilterParameters(), two_parts());
    EXPECT_LE(PartDecoders(FilterParameters(), wide).bytes(), narrow.bytes() + 8 * 100'000);
    // Beside the decoders, room for 4096 events at once, and less than a kilobyte.
    std::size_t decoders = 0;
    for (const Part& part : two_parts()) decoders += GripDecoder(FilterParameters(), alone(part)).bytes();
    EXPECT_GE(narrow.bytes(), decoders + 4096 * sizeof(Event));
    EXPECT_LT(narrow.bytes(), decoders + 4096 * sizeof(Event) + 1024);
}

}  // namespace
}  // namespace afferent
