// The line of a chip: heard from the beginning or later, cut, disturbed, of another chip, or with a bad
// clock.
#include "afferent/nodes/chip_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "afferent/nodes/run_summary.hpp"
#include "afferent/scene/plan_bounds.hpp"
#include "tests/nodes/emulated_chip.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

std::string scene_of_a_chip(const std::string& chip = "compare: true", int duration_s = 60) {
    return "duration_s: " + std::to_string(duration_s) + " source { chip { device: 'tty' " + chip +
           " } } link { tcp {} } hand {} "
           "patch { name: 'thumb' elements: 3 share: [0.2, 0.2, 0.1] neuron { delta_g: 0.03 fixed_point {} } "
           "}"
           "patch { name: 'index' elements: 2 share: [0.1, 0.1] neuron { delta_g: 0.03 fixed_point {} } }";
}

// Nothing, and from 0.5 s on a force that comes and goes.
double counts_of_touches(TimePoint time) {
    const double s = seconds(time);
    return s < 0.5 ? 0 : std::round(1500 * (1 - std::cos(5 * (s - 0.5))));
}

// A chip on a line, and what is heard of it. The chip's clock begins at this time of the scene's.
class Heard {
  public:
    explicit Heard(Duration begins = 0ms, const std::string& chip_field = "compare: true",
                   std::function<double(TimePoint)> counts = counts_of_touches)
        : plan(make_plan(Scene::from_text(scene_of_a_chip(chip_field)))),
          chip(plan.scene, std::move(counts)),
          emulator(plan),
          reader(plan, traits_of(plan.scene.source).emulated ? &emulator : nullptr),
          begins_(begins) {}

    void run_for(Duration length) {
        chip.run_until(chip.now() + length, [&](TimePoint sent, std::vector<std::byte> bytes) {
            if (disturb) disturb(bytes);
            const auto since = std::chrono::duration_cast<Duration>(Interval(sent - scene_start) / rate);
            const Duration at = begins_ + since + delay;
            if (listening) reader.read(MonotonicTime(at), scene_start + at, bytes);
            for (auto note = reader.next_note(); note; note = reader.next_note()) notes.push_back(*note);
            const auto taken = reader.take(reader.known_until() - Duration(1));
            events.insert(events.end(), taken.begin(), taken.end());
        });
    }

    const Plan plan;
    EmulatedChip chip;
    Coprocessor emulator;
    ChipReader reader;
    std::function<void(std::vector<std::byte>&)> disturb;
    double rate = 1;
    Duration delay = 0ms;
    bool listening = true;
    std::vector<Event> events;
    std::vector<std::string> notes;

  private:
    Duration begins_;
};

std::vector<Event> shifted(std::vector<Event> events, Duration by, Duration tick) {
    for (Event& event : events) event.time = scene_start + (event.time - scene_start) / tick * tick + by;
    std::ranges::sort(events, [](const Event& a, const Event& b) {
        return a.time != b.time ? a.time < b.time : a.address < b.address;
    });
    return events;
}

TEST(ChipReader, TellsTheChipsEventsInTheTimeOfTheScene) {
    Heard heard(1003ms);
    heard.delay = 2ms;
    heard.run_for(5s);
    ASSERT_GT(heard.events.size(), 200U);
    EXPECT_EQ(heard.events, shifted(heard.chip.fired, 1005ms, 100us)) << "by whole spans of 5 ms";
    EXPECT_TRUE(heard.reader.knows(scene_start + 1010ms, heard.reader.known_until()));
    EXPECT_FALSE(heard.reader.knows(scene_start + 1000ms, scene_start + 1010ms)) << "before it was heard";
    const ChipReport report = heard.reader.report();
    EXPECT_EQ(report.beginnings, 1U);
    EXPECT_EQ(report.gaps, 0U);
    EXPECT_EQ(report.lost_events, 0U);
    EXPECT_EQ(report.clock_jumps, 0U);
    EXPECT_NEAR(report.clock_ppm, 0, 1);
    EXPECT_EQ(report.comparison->equal, heard.events.size());
    EXPECT_EQ(report.comparison->chip_alone + report.comparison->emulator_alone, 0U);
    EXPECT_EQ(report.comparison->readings, 995U) << "five came before the first packet";
    EXPECT_EQ(report.comparison->refused_readings, 0U);
    EXPECT_TRUE(heard.notes.empty());
}

TEST(ChipReader, FollowsAChipThatHasRunForLong) {
    Heard heard;
    heard.listening = false;
    heard.run_for(100s);  // positions have come round
    heard.listening = true;
    const std::size_t before = heard.chip.fired.size();
    heard.run_for(20s);
    // But for the packet before it has said which it is.
    EXPECT_LE(heard.chip.fired.size() - before - heard.events.size(), 10U);
    const ChipReport report = heard.reader.report();
    EXPECT_EQ(report.lost_events, 0U) << "what was before it was listened to is not lost";
    EXPECT_EQ(report.refused_packets, 0U);
    EXPECT_EQ(report.comparison->refused_readings, 0U);
    // The neurons forget how they were, and then fire as the emulator's do.
    EXPECT_GT(report.comparison->equal, 500U);
    EXPECT_EQ(report.comparison->chip_alone + report.comparison->emulator_alone, 0U);
}

// Bytes wait while the session begins: no event is from before it, where no packet could carry it.
TEST(ChipReader, TellsNothingFromBeforeTheSceneBegins) {
    Heard heard(-3s);
    heard.listening = false;
    heard.run_for(2900ms);
    heard.listening = true;
    heard.run_for(2s);
    ASSERT_GT(heard.events.size(), 100U);
    EXPECT_GE(heard.events.front().time, scene_start);
    EXPECT_LT(heard.events.front().time, scene_start + 200ms);
    Heard later(-3s);
    later.reader.begin_at(scene_start + 1s);
    EXPECT_EQ(later.reader.known_until(), scene_start + 1s);
    later.listening = false;
    later.run_for(3900ms);
    later.listening = true;
    later.run_for(2s);
    ASSERT_GT(later.events.size(), 100U);
    EXPECT_GE(later.events.front().time, scene_start + 1s);
    EXPECT_LT(later.events.front().time, scene_start + 1200ms);
}

// Without readings nothing says how often positions have come round.
TEST(ChipReader, FollowsAChipThatSendsNothingButPackets) {
    for (const Duration before : {5s, 60s, 100s}) {
        Heard heard(0ms, "");
        heard.listening = false;
        heard.run_for(before);
        heard.listening = true;
        const std::size_t fired = heard.chip.fired.size();
        heard.run_for(2s);
        EXPECT_LE(heard.chip.fired.size() - fired - heard.events.size(), 10U);
        EXPECT_GT(heard.events.size(), 100U);
        EXPECT_EQ(heard.reader.report().beginnings, 1U);
        EXPECT_EQ(heard.reader.report().refused_packets, 0U);
    }
}

// Positions have gone on by more than half of all there are, so that its packets look like old ones.
TEST(ChipReader, FollowsAChipAgainThatWasNotHeardForLong) {
    Heard heard(0ms, "");
    heard.run_for(2s);
    heard.listening = false;
    heard.run_for(45s);
    heard.listening = true;
    const std::size_t fired = heard.chip.fired.size();
    const std::size_t told = heard.events.size();
    heard.run_for(5s);
    EXPECT_GT(heard.events.size(), told + 200);
    EXPECT_LE(heard.chip.fired.size() - fired - (heard.events.size() - told), 10U);
    EXPECT_EQ(heard.reader.report().refused_packets, 2U) << "the third is taken for a new beginning";
    ASSERT_EQ(heard.notes.size(), 1U);
    EXPECT_NE(heard.notes[0].find("has begun again, or its packets do not follow"), std::string::npos)
        << heard.notes[0];
}

TEST(ChipReader, KnowsWhatItHasNotHeard) {
    Heard heard;
    heard.run_for(1s);
    heard.listening = false;
    const TimePoint from = heard.reader.known_until();
    heard.run_for(50ms);
    heard.listening = true;
    heard.run_for(2s);
    EXPECT_FALSE(heard.reader.knows(from, from + 5ms));
    EXPECT_FALSE(heard.reader.knows(from - 20ms, from + 100ms));
    EXPECT_TRUE(heard.reader.knows(from - 20ms, from));
    EXPECT_TRUE(heard.reader.knows(from + 60ms, from + 1s));
    const ChipReport report = heard.reader.report();
    EXPECT_EQ(report.gaps, 1U);
    EXPECT_EQ(report.lost_events, heard.chip.fired.size() - heard.events.size());
    EXPECT_GT(report.lost_events, 0U);
}

TEST(ChipReader, DropsFramesThatWereDisturbed) {
    Heard heard;
    std::mt19937 random(1);
    std::uint64_t disturbed = 0;
    heard.disturb = [&](std::vector<std::byte>& bytes) {
        if (random() % 20 != 0) return;
        ++disturbed;
        bytes[1 + random() % (bytes.size() - 2)] ^= static_cast<std::byte>(1 + random() % 255);
    };
    heard.run_for(20s);
    const ChipReport report = heard.reader.report();
    // A zero in the midst makes two stretches of one frame.
    EXPECT_GE(report.frames.checksum_failures + report.frames.refused + report.refused_bytes, disturbed);
    EXPECT_EQ(report.lost_events + heard.events.size() + 0U, heard.chip.fired.size());
    EXPECT_GT(report.gaps, 10U);
    EXPECT_EQ(report.beginnings, 1U);
    EXPECT_EQ(report.comparison->chip_alone + report.comparison->emulator_alone, 0U)
        << "lost readings are no fault of the chip";
}

TEST(ChipReader, NoticesThatTheChipHasBegunAgain) {
    Heard heard;
    heard.run_for(3s);
    const TimePoint last = heard.reader.known_until();
    heard.chip.begin();
    heard.chip.fired.clear();
    heard.events.clear();
    Heard& again = heard;
    again.delay = 3100ms;  // its clock begins at 0, 100 ms later
    again.run_for(3s);
    EXPECT_EQ(heard.reader.report().beginnings, 2U);
    EXPECT_FALSE(heard.reader.knows(last, last + 100ms));
    EXPECT_EQ(heard.events, shifted(heard.chip.fired, 3100ms, 100us));
    EXPECT_EQ(heard.reader.report().comparison->chip_alone, 0U);
    EXPECT_EQ(heard.reader.report().comparison->emulator_alone, 0U);
    ASSERT_FALSE(heard.notes.empty());
    EXPECT_NE(heard.notes[0].find("has begun again"), std::string::npos) << heard.notes[0];
}

TEST(ChipReader, DoesNotTakeAnotherChipForTheScenes) {
    Heard heard;
    heard.chip.another = 1;
    heard.run_for(3s);
    EXPECT_TRUE(heard.events.empty());
    EXPECT_GT(heard.reader.report().unknown_packets, 100U);
    ASSERT_EQ(heard.notes.size(), 1U);
    EXPECT_NE(heard.notes[0].find("another chip than the scene's"), std::string::npos) << heard.notes[0];
    EXPECT_NE(heard.notes[0].find("packets of 5000 us; here version " + std::to_string(wire_version) +
                                  ", 5, 5000 us."),
              std::string::npos)
        << heard.notes[0];
    heard.chip.another = 0;
    heard.run_for(3s);
    EXPECT_GT(heard.events.size(), 100U) << "the right one has been put in";
    heard.chip.another = 2;
    heard.run_for(100ms);
    heard.events.clear();
    heard.run_for(1s);
    EXPECT_TRUE(heard.events.empty());
}

TEST(ChipReader, DoesNotUseAChipThatDoesNotSayWhichItIs) {
    Heard heard;
    heard.chip.says_which = false;
    heard.run_for(3s);
    EXPECT_TRUE(heard.events.empty());
    ASSERT_EQ(heard.notes.size(), 1U);
    EXPECT_NE(heard.notes[0].find("does not say which it is"), std::string::npos) << heard.notes[0];
    heard.chip.says_which = true;
    heard.run_for(2s);
    EXPECT_GT(heard.events.size(), 100U);
}

// The neurons are given half of what the converters read, and nothing was compared before.
TEST(ChipReader, SaysThatAChipDoesNotFireLikeItsReadings) {
    Heard heard;
    heard.listening = false;
    heard.run_for(100ms);
    heard.listening = true;
    heard.chip.felt = 0.5;
    heard.run_for(20s);
    EXPECT_LT(heard.reader.report().comparison->equal, heard.events.size() / 20) << "by chance";
    EXPECT_EQ(heard.notes.size(), 5U) << "for each afferent";
    ASSERT_FALSE(heard.notes.empty());
    EXPECT_NE(heard.notes[0].find("are equal in chip and emulator: they differ"), std::string::npos)
        << heard.notes[0];
}

// The other afferents are compared all the same.
TEST(ChipReader, SaysWhichAfferentIsDead) {
    Heard heard;
    heard.listening = false;
    heard.run_for(100ms);
    heard.listening = true;
    heard.chip.change = [](std::vector<Event>& events) {
        if (events.back().address == 2) events.pop_back();
    };
    heard.run_for(20s);
    const ChipComparison::Counts counts = *heard.reader.report().comparison;
    EXPECT_GT(counts.equal, heard.events.size() / 2);
    EXPECT_EQ(counts.chip_alone + counts.emulator_alone, 0U);
    ASSERT_EQ(heard.notes.size(), 1U);
    EXPECT_NE(heard.notes[0].find("of the first 100 events of address 2 0 are equal"), std::string::npos)
        << heard.notes[0];
}

TEST(ChipReader, SaysNothingOfAnAfferentHalfOfWhoseEventsAreTheEmulators) {
    Heard heard;
    heard.listening = false;
    heard.run_for(100ms);
    heard.listening = true;
    int events_of_2 = 0;
    heard.chip.change = [&](std::vector<Event>& events) {
        if (events.back().address == 2 && events_of_2++ % 2 == 0) events.pop_back();
    };
    heard.run_for(20s);
    EXPECT_GT(events_of_2, 100);
    for (const std::string& note : heard.notes)
        EXPECT_EQ(note.find("are equal in chip and emulator"), std::string::npos) << note;
}

// In a packet of 5 ms: those of its highest rate, one more, and another by the tick.
TEST(ChipReader, UsesAsManyEventsAsANeuronCanFire) {
    for (const int too_many : {0, 1}) {
        Heard heard;
        heard.run_for(1s);
        const int most = 2 + static_cast<int>(0.005 * highest_rate_hz(heard.plan, heard.plan.patches[0], 0));
        heard.chip.change = [&](std::vector<Event>& events) {
            const Event event = events.back();
            std::erase_if(events, [&](const Event& one) { return one.address == event.address; });
            if (event.address == 0) events.insert(events.end(), most + too_many, event);
        };
        heard.run_for(1s);
        EXPECT_EQ(heard.reader.report().implausible_packets > 0, too_many == 1);
    }
}

TEST(ChipReader, DoesNotUseWhatNoNeuronCanFire) {
    Heard heard;
    heard.run_for(1s);
    heard.chip.change = [](std::vector<Event>& events) {
        const Event event = events.back();
        for (int i = 0; i < 30; ++i) events.push_back(event);
    };
    const std::size_t before = heard.events.size();
    heard.run_for(1s);
    EXPECT_EQ(heard.events.size(), before);
    EXPECT_GT(heard.reader.report().implausible_packets, 10U);
    const TimePoint now = heard.reader.known_until();
    EXPECT_FALSE(heard.reader.knows(now - 20ms, now));
}

TEST(ChipReader, TakesAChipWithoutSamplesForOneThatKnowsNothing) {
    Heard heard;
    heard.run_for(1s);
    const TimePoint from = heard.reader.known_until();
    proto::Envelope packet;
    packet.set_position(static_cast<std::uint32_t>((from - scene_start) / 5ms) + 2);
    packet.set_spans(1);
    packet.set_no_samples_since_ns(0);
    FrameWriter writer;
    std::vector<std::byte> line;
    append_cobs(writer.datagram(packet), line);
    heard.reader.read(MonotonicTime(1005ms), scene_start + 1005ms, line);
    EXPECT_EQ(heard.reader.known_until(), from + 5ms);
    EXPECT_FALSE(heard.reader.knows(from, from + 5ms));
}

TEST(ChipReader, ComparesNothingWithoutReadings) {
    Heard heard;
    heard.chip.sends_readings = false;
    heard.run_for(5s);
    EXPECT_GT(heard.events.size(), 200U);
    const ChipComparison::Counts counts = *heard.reader.report().comparison;
    EXPECT_EQ(counts.not_compared, heard.events.size());
    EXPECT_EQ(counts.chip_alone + counts.emulator_alone + counts.equal, 0U);
    ASSERT_EQ(heard.notes.size(), 1U);
    EXPECT_NE(heard.notes[0].find("sends no readings"), std::string::npos);
}

TEST(ChipReader, SaysWhereChipAndEmulatorPart) {
    Heard heard;
    std::optional<Event> missing;
    heard.chip.change = [&](std::vector<Event>& events) {
        if (missing || events.back().address != 3 || events.back().time < scene_start + 2s) return;
        missing = events.back();
        events.pop_back();
    };
    heard.run_for(5s);
    ASSERT_TRUE(missing);
    const ChipComparison::Counts counts = *heard.reader.report().comparison;
    EXPECT_EQ(counts.emulator_alone, 1U);
    EXPECT_EQ(counts.chip_alone, 0U);
    EXPECT_EQ(counts.equal, heard.events.size());
    ASSERT_EQ(heard.notes.size(), 1U);
    EXPECT_NE(heard.notes[0].find("address 3 fires in the emulator alone"), std::string::npos)
        << heard.notes[0];
}

// A touch that holds keeps the shift between two neurons. A silence that is long enough ends that.
TEST(ChipReader, CountsDifferencesAgainAfterASilence) {
    Heard heard(0ms, "compare: true", [](TimePoint time) {
        const double s = seconds(time);
        // Held with a tremor, let go for 5 s, and held again.
        return s < 0.5 || (s > 20 && s < 25) ? 0 : std::round(1500 + 200 * std::sin(40 * s));
    });
    heard.run_for(1s);
    const std::uint64_t whole = heard.reader.report().comparison->equal;
    EXPECT_GT(whole, 20U);
    heard.disturb = [](std::vector<std::byte>& bytes) { bytes[bytes.size() / 2] ^= std::byte{0x55}; };
    heard.run_for(100ms);  // of frames are lost
    heard.disturb = nullptr;
    heard.run_for(18900ms);
    const ChipComparison::Counts held = *heard.reader.report().comparison;
    EXPECT_GT(held.not_compared, 10U);
    EXPECT_EQ(held.chip_alone + held.emulator_alone, 0U) << "they may differ";
    heard.run_for(10s);
    const ChipComparison::Counts again = *heard.reader.report().comparison;
    EXPECT_LE(again.not_compared, held.not_compared + 20) << "those of the last packet before the silence";
    EXPECT_GT(again.equal, held.equal + 100);
    EXPECT_EQ(again.chip_alone + again.emulator_alone, 0U);
    heard.chip.change = [](std::vector<Event>& events) {
        if (events.back().address == 2) events.pop_back();
    };
    heard.run_for(1s);
    EXPECT_GT(heard.reader.report().comparison->emulator_alone, 5U);
}

TEST(ChipReader, TellsTenDifferencesAndThenNumbersAlone) {
    Heard heard;
    std::uint64_t skipped = 0;
    heard.chip.change = [&, since = 0](std::vector<Event>& events) mutable {
        if (events.back().address != 3 || ++since % 40 != 0) return;
        events.pop_back();
        ++skipped;
    };
    heard.run_for(40s);
    ASSERT_GT(skipped, 12U);
    EXPECT_GT(heard.reader.report().comparison->emulator_alone, 10U);
    ASSERT_EQ(heard.notes.size(), 10U);
    const std::string last = "of further ones only the numbers are told";
    EXPECT_EQ(heard.notes[8].find(last), std::string::npos) << heard.notes[8];
    EXPECT_NE(heard.notes[9].find(last), std::string::npos) << heard.notes[9];
}

TEST(ChipReader, SkipsSpansOfAClockThatIsFarOff) {
    for (const double rate : {1.03, 0.97}) {
        Heard heard;
        heard.rate = rate;
        heard.run_for(10s);
        const ChipReport report = heard.reader.report();
        EXPECT_NEAR(report.clock_ppm, 1e6 * (rate - 1), 2000) << rate;
        EXPECT_GT(report.clock_jumps, 5U);
        EXPECT_LT(report.clock_jumps, 100U);
        ASSERT_EQ(heard.notes.size(), 1U);
        EXPECT_NE(heard.notes[0].find("clock differs by more than 2000 ppm"), std::string::npos);
        // Never far from when they came.
        const Duration length = std::chrono::duration_cast<Duration>(Interval(10s) / rate);
        EXPECT_LT(std::abs(seconds(heard.reader.known_until()) - seconds(scene_start + length)), 0.02);
        EXPECT_GT(heard.events.size(), heard.chip.fired.size() * 9 / 10);
    }
}

// Whatever comes: nothing grows, hangs or ends the program, and the right chip is followed afterwards.
TEST(ChipReader, SurvivesAnything) {
    Heard heard;
    std::mt19937 random(1);
    std::vector<std::byte> earlier;
    heard.disturb = [&](std::vector<std::byte>& bytes) {
        switch (random() % 4) {
            case 0:
                for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % 256);
                break;
            case 1:  // a frame with a good checksum, of fields that cannot be
                proto::Envelope message;
                if (random() % 2 == 0) {
                    message.set_position(static_cast<std::uint32_t>(random() % 20'000));
                    message.set_spans(static_cast<std::uint32_t>(random() >> (random() % 32)));
                    if (random() % 2 == 0) message.set_count(static_cast<std::uint32_t>(random()));
                    if (random() % 2 == 0)
                        message.set_begin((std::uint64_t{random()} << 32 | random()) >> (random() % 64));
                    std::string payload(random() % 12, '\0');
                    for (char& byte : payload) byte = static_cast<char>(random());
                    message.set_payload(payload);
                } else {
                    proto::Readings& readings = *message.mutable_readings();
                    readings.set_tick((std::uint64_t{random()} << 32 | random()) >> (random() % 64));
                    readings.set_first(static_cast<std::uint32_t>(random() >> (random() % 32)));
                    for (std::uint32_t i = random() % 8; i > 0; --i)
                        readings.add_counts(static_cast<std::uint32_t>(random()));
                }
                FrameWriter writer;
                bytes.clear();
                append_cobs(writer.datagram(message), bytes);
                break;
        }
    };
    heard.run_for(60s);
    heard.disturb = nullptr;
    heard.run_for(1s);
    heard.events.clear();
    heard.chip.fired.clear();
    heard.run_for(5s);
    EXPECT_GE(heard.events.size() + 10, heard.chip.fired.size());
    EXPECT_GT(heard.events.size(), 100U);
}

// A chip beside a coprocessor and a hand, on a clock of its own.
class ChipOfTwo final : public ChipDevice {
  public:
    ChipOfTwo(TwoNodes& two, double rate) : two_(two), rate_(rate), chip_(two.plan.scene, counts_of_touches) {
        // What was on the line before the chip began.
        waiting_.push_back({two.now, {std::byte{7}, std::byte{7}, std::byte{0}}});
    }

    const ChipBytes* next() override {
        const Duration since = two_.now - MonotonicTime(std::chrono::hours(1));
        const auto now = scene_start + std::chrono::duration_cast<Duration>(rate_ * Interval(since));
        chip_.run_until(now, [&](TimePoint, std::vector<std::byte> bytes) {
            if (!silent) waiting_.push_back({two_.now, std::move(bytes)});
        });
        if (waiting_.empty()) return nullptr;
        next_ = std::move(waiting_.front());
        waiting_.erase(waiting_.begin());
        return &next_;
    }
    std::optional<std::string> next_note() override { return std::nullopt; }
    const std::vector<Event>& fired() const { return chip_.fired; }

    bool silent = false;

  private:
    TwoNodes& two_;
    double rate_;
    EmulatedChip chip_;
    std::vector<ChipBytes> waiting_;
    ChipBytes next_;
};

TEST(CoprocessorNode, PassesTheEventsOfAChipOn) {
    for (const double rate : {1.0, 1.0005, 0.9995}) {
        TwoNodes two(scene_of_a_chip("compare: true", 30));
        auto line = std::make_unique<ChipOfTwo>(two, rate);
        const ChipOfTwo& chip = *line;
        two.start_hand();
        two.start_coprocessor(two.plan, {}, std::move(line));
        two.run_to_the_end();
        EXPECT_TRUE(two.hand.safe.empty()) << rate << two.hand.safe.front();
        const HandNode::Report report = two.hand.node->report();
        EXPECT_LE(report.received.gaps, 1U) << "before it is heard";
        EXPECT_GE(two.hand.events.size() + 20, chip.fired().size()) << "but for those of its last packet";
        EXPECT_EQ(report.received.stale, 0U);
        const ChipReport of_chip = two.coprocessor.node->link_end().chip()->report();
        EXPECT_EQ(of_chip.late_events, 0U);
        EXPECT_EQ(of_chip.clock_jumps, 0U);
        EXPECT_NEAR(of_chip.clock_ppm, 1e6 * (rate - 1), 60) << "packets come within a millisecond";
        EXPECT_EQ(of_chip.comparison->chip_alone + of_chip.comparison->emulator_alone, 0U);
        EXPECT_GT(of_chip.comparison->equal, 1000U);
        if (rate != 1) continue;

        const Summary summary = summary_of(*two.coprocessor.node);
        const auto expect = [](const Summary* of, const char* key, double value) {
            ASSERT_TRUE(of && of->find(key)) << key;
            EXPECT_EQ(of->find(key)->number(), value) << key;
        };
        const Summary* const told = summary.find("chip");
        expect(told, "beginnings", 1);
        expect(told, "packets", static_cast<double>(of_chip.packets));
        expect(told, "gaps", static_cast<double>(of_chip.gaps));
        expect(told, "lost_events", static_cast<double>(of_chip.lost_events));
        expect(told, "refused_frames", 1);
        expect(told, "clock_ppm", of_chip.clock_ppm);
        for (const char* const none : {"late_events", "refused_packets", "unknown_packets",
                                       "implausible_packets", "checksum_failures", "clock_jumps"})
            expect(told, none, 0);
        ASSERT_TRUE(told);
        const Summary* const compared = told->find("comparison");
        expect(compared, "readings", static_cast<double>(of_chip.comparison->readings));
        expect(compared, "equal", static_cast<double>(of_chip.comparison->equal));
        expect(compared, "not_compared", static_cast<double>(of_chip.comparison->not_compared));
        for (const char* const none : {"chip_alone", "emulator_alone", "refused_readings"})
            expect(compared, none, 0);
    }
}

// Silence of a chip is no silence of its skin.
TEST(CoprocessorNode, TellsThatAChipIsSilent) {
    TwoNodes two(scene_of_a_chip("", 10));
    auto line = std::make_unique<ChipOfTwo>(two, 1);
    ChipOfTwo& chip = *line;
    two.start_hand();
    two.start_coprocessor(two.plan, {}, std::move(line));
    two.run_for(3s);
    ASSERT_TRUE(two.hand.safe.empty());
    chip.silent = true;
    two.run_for(60ms + 150ms + 50ms);
    ASSERT_EQ(two.hand.safe.size(), 1U);
    EXPECT_NE(two.hand.safe[0].find("no samples from the sensors"), std::string::npos) << two.hand.safe[0];
    chip.silent = false;
    two.run_for(2s);
    EXPECT_EQ(two.hand.safe.size(), 1U);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
}

TEST(CoprocessorNode, DoesNotGoInLockstepWithAChip) {
    TwoNodes two(scene_of_a_chip());
    EXPECT_THROW(two.start_coprocessor(two.plan, {.lockstep = true}, std::make_unique<ChipOfTwo>(two, 1)),
                 std::runtime_error);
}

TEST(Run, RefusesAChipThatIsOnALine) {
    const Plan plan = make_plan(Scene::from_text(scene_of_a_chip()));
    const auto run = Run::open(plan, {});
    ASSERT_FALSE(run);
    EXPECT_NE(run.error().text.find("`afferent coprocessor` reads it"), std::string::npos);
}

}  // namespace
}  // namespace afferent
