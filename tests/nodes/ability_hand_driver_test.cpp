// A driver and an emulated hand on one line, in virtual time.
#include "afferent/nodes/ability_hand_driver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "afferent/hand/ability_hand_emulator.hpp"

namespace afferent {
namespace {

constexpr double limit_n = 8;
constexpr Duration freeze = 60ms;
constexpr Duration safe = 150ms;

struct Rig {
    explicit Rig(scene::AbilityHand hand = {},
                 AbilityHandEmulator::Parameters parameters = {.breaking_n = limit_n})
        : driver(driver_parameters(hand), wall_time(scene_start)), emulator(parameters) {}

    static AbilityHandDriver::Parameters driver_parameters(scene::AbilityHand hand) {
        if (hand.zero_counts.empty()) hand.zero_counts.assign(ability_hand::sensors, 15);
        AbilityHandDriver::Parameters parameters{
            .hand = hand, .full_scale_n = {}, .freeze = freeze, .safe = safe};
        parameters.full_scale_n.fill(6);
        return parameters;
    }

    // The command of a user who closes, under a gain that falls from 1 N on and is 0 from 6 N on.
    void close_by_force() {
        steer = [this] { return force_n < 1 ? 1.0 : force_n < 6 ? std::exp(1 - force_n) : 0.0; };
    }

    void run(Duration span) {
        for (const TimePoint end = now + span; now < end; now += 100us) {
            const MonotonicTime wall = wall_time(now);
            if (steer) driver.follow({steer(), wall, wall_time(now - decoder_lag)});
            const auto request = driver.poll(wall);
            if (!cut && !request.empty()) emulator.receive(now, request);
            emulator.advance(now);
            std::vector<std::byte> reply;
            emulator.send(now, reply);
            if (!cut)
                driver.read(wall, reply, [this](MonotonicTime, std::span<const double> forces_n) {
                    force_n = std::accumulate(forces_n.begin(), forces_n.end(), 0.0);
                    forces.assign(forces_n.begin(), forces_n.end());
                });
            fastest_deg = std::max(fastest_deg, std::abs(emulator.position_deg(0) - position_deg));
            position_deg = emulator.position_deg(0);
        }
    }

    std::string notes() {
        std::string all;
        while (const auto note = driver.next_note()) all += *note + "\n";
        return all;
    }
    HandReadings readings() { return driver.readings(wall_time(now)); }

    AbilityHandDriver driver;
    AbilityHandEmulator emulator;
    std::function<double()> steer;
    TimePoint now = scene_start;
    double force_n = 0;
    std::vector<double> forces;
    bool cut = false;
    Duration decoder_lag = 0ms;  // by which what a command knows is older than the command
    double position_deg = 0;
    double fastest_deg = 0;  // within 0.1 ms
};

TEST(AbilityHandDriver, HoldsAnObjectByWhatItsSensorsFeel) {
    Rig rig;
    rig.close_by_force();
    rig.run(3s);
    EXPECT_FALSE(rig.emulator.broken()) << rig.emulator.highest_grip_n();
    EXPECT_GT(rig.emulator.grip_n(), 3);
    // Zeros differ by up to 8 counts from those that were told: thirty times 0.02 N.
    EXPECT_NEAR(rig.force_n, rig.emulator.grip_n(), 0.7);
    // 120 degrees a second, and what a finger catches up.
    EXPECT_LT(rig.fastest_deg, 200 * 1e-4);
    const HandReadings readings = rig.readings();
    EXPECT_TRUE(readings.answering);
    EXPECT_TRUE(readings.driven);
    EXPECT_NEAR(static_cast<double>(readings.replies), 1500, 15);
    EXPECT_EQ(readings.unanswered, 0U);
    EXPECT_EQ(readings.refused_frames + readings.implausible_replies, 0U);
    EXPECT_NEAR(readings.motors[0].position_deg, rig.emulator.position_deg(0), 0.5);
}

TEST(AbilityHandDriver, HoldsItInEveryMode) {
    for (const scene::FingerDrive& drive : std::initializer_list<scene::FingerDrive>{
             scene::VelocityDrive(), scene::CurrentDrive{.current_a = 0.3},
             scene::DutyDrive{.duty_percent = 40}}) {
        scene::AbilityHand hand;
        hand.drive = drive;
        Rig rig(hand);
        rig.close_by_force();
        rig.run(4s);
        EXPECT_FALSE(rig.emulator.broken()) << drive.index() << ": " << rig.emulator.highest_grip_n();
        EXPECT_GT(rig.emulator.grip_n(), 1) << drive.index();
    }
}

TEST(AbilityHandDriver, OnlyReadsUntilTheControllerHasSpoken) {
    Rig rig;
    rig.run(500ms);
    EXPECT_FALSE(rig.emulator.driven());
    EXPECT_EQ(rig.emulator.position_deg(0), 0);
    EXPECT_GT(rig.readings().replies, 200U);
    EXPECT_EQ(rig.readings().commands, 0U);
}

TEST(AbilityHandDriver, DoesNotMoveByWhatIsNoCommand) {
    Rig rig;
    rig.steer = [] { return std::nan(""); };
    rig.run(1s);
    EXPECT_LT(rig.emulator.position_deg(0), 0.5);
    rig.steer = [] { return 1e300; };
    rig.run(100ms);
    EXPECT_LT(rig.emulator.position_deg(0), 0.5 + 120 * 0.1 + 0.5);
}

TEST(AbilityHandDriver, StopsClosingWhenTheControllerFallsSilentAndThenLetsTheHandStand) {
    Rig rig({}, {.distance_mm = 1000});
    rig.steer = [] { return 0.5; };
    rig.run(300ms);
    rig.steer = nullptr;
    rig.run(freeze);
    const double at_freeze_deg = rig.emulator.position_deg(0);
    rig.run(safe);
    // Its servo catches up with a target that stands.
    EXPECT_LT(rig.emulator.position_deg(0), at_freeze_deg + 8);
    EXPECT_FALSE(rig.readings().driven);
    rig.run(300ms);
    EXPECT_FALSE(rig.emulator.driven());
}

TEST(AbilityHandDriver, NamesASensorThatIsAtFullScaleAndOneThatIsDead) {
    Rig rig;
    rig.close_by_force();
    rig.emulator.faults().stuck_counts[24] = ability_hand::most_counts;
    rig.emulator.faults().stuck_counts[7] = 0;
    rig.run(2s);
    EXPECT_EQ(rig.forces[24], 6);
    const std::string notes = rig.notes();
    EXPECT_NE(notes.find("sensor thumb 1 is at full scale"), std::string::npos) << notes;
    EXPECT_EQ(std::ranges::count(notes, '\n'), 2) << "each is told of once: " << notes;
    EXPECT_NE(notes.find("sensor middle 2 reads 0"), std::string::npos) << notes;
}

TEST(AbilityHandDriver, GripsAtMostByItsShareMoreWhenASensorIsDead) {
    Rig whole;
    whole.close_by_force();
    whole.run(3s);
    Rig rig;
    rig.close_by_force();
    rig.emulator.faults().stuck_counts[24] = 0;
    rig.run(3s);
    // The thumb's first sensor has 15 % of the force.
    EXPECT_LE(rig.emulator.highest_grip_n(), whole.emulator.highest_grip_n() / 0.85 + 0.3);
    EXPECT_FALSE(rig.emulator.broken());
}

TEST(AbilityHandDriver, TakesAZeroThatNothingTouchesAndRefusesOneThatHidesAForce) {
    Rig rig;
    rig.run(100ms);
    const double before_n = rig.force_n;
    rig.driver.take_zero(wall_time(rig.now));
    rig.run(600ms);
    EXPECT_NE(rig.notes().find("the zero has been taken"), std::string::npos);
    EXPECT_EQ(rig.readings().zeros_taken, 1U);
    EXPECT_LT(rig.force_n, before_n);

    const auto zero = rig.driver.zero_counts();
    rig.emulator.faults().pressing_n = 2;
    rig.run(100ms);
    rig.driver.take_zero(wall_time(rig.now));
    rig.run(600ms);
    const std::string notes = rig.notes();
    EXPECT_NE(notes.find("the zero stays as it was"), std::string::npos) << notes;
    EXPECT_NE(notes.find("thumb 1 by 0.3"), std::string::npos) << notes;
    EXPECT_EQ(rig.readings().zeros_refused, 1U);
    EXPECT_EQ(rig.driver.zero_counts(), zero);
    EXPECT_NEAR(rig.force_n, 2, 0.2);
}

// A twenty-fifth of what presses falls to the first sensor of the index.
TEST(AbilityHandDriver, NamesTheSensorsThatReadATwentiethOfANewtonMoreThanTheirZero) {
    for (const auto& [pressing_n, is_named] : {std::pair{1.1, false}, std::pair{1.5, true}}) {
        Rig rig;
        rig.emulator.faults().pressing_n = pressing_n;
        rig.run(100ms);
        rig.driver.take_zero(wall_time(rig.now));
        rig.run(600ms);
        const std::string notes = rig.notes();
        EXPECT_NE(notes.find("the zero stays as it was"), std::string::npos) << notes;
        EXPECT_EQ(notes.find("index 1 by 0.06 N") != std::string::npos, is_named) << notes;
        EXPECT_EQ(notes.find("index 1 by") != std::string::npos, is_named) << notes;
    }
}

TEST(AbilityHandDriver, TakesNoZeroWhileASensorVariesByMoreThanSixtyCounts) {
    for (const auto& [counts, is_steady] : {std::pair{75, true}, std::pair{76, false}}) {
        Rig rig;
        rig.emulator.faults().stuck_counts[3] = 15;
        rig.run(100ms);
        rig.driver.take_zero(wall_time(rig.now));
        rig.run(200ms);
        rig.emulator.faults().stuck_counts[3] = static_cast<std::uint16_t>(counts);
        rig.run(400ms);
        const std::string notes = rig.notes();
        EXPECT_EQ(notes.find("is not steady") == std::string::npos, is_steady) << notes;
    }
}

TEST(AbilityHandDriver, SaysThatAHandDoesNotAnswer) {
    scene::AbilityHand hand;
    hand.address = 81;
    Rig wrong(hand);
    wrong.run(3s);
    EXPECT_EQ(wrong.notes(),
              "the hand does not answer at address 81 and 921600 baud: is it on, and are these its own?\n");
    Rig rig;
    rig.run(1s);
    rig.cut = true;
    rig.run(3s);
    EXPECT_EQ(rig.notes(), "the hand does not answer any more\n");
    rig.cut = false;
    rig.run(1s);
    EXPECT_EQ(rig.notes(), "the hand answers again\n");
}

TEST(AbilityHandDriver, DoesNotBelieveAZeroThatIsHigherThanWhatTheSensorsRead) {
    scene::AbilityHand hand;
    hand.zero_counts.assign(ability_hand::sensors, 300);
    Rig rig(hand);
    rig.run(500ms);
    const std::string notes = rig.notes();
    EXPECT_NE(notes.find("zero_counts are too high"), std::string::npos) << notes;
    EXPECT_NE(notes.find("thumb 6"), std::string::npos) << notes;
    rig.close_by_force();
    rig.run(3s);
    EXPECT_FALSE(rig.emulator.broken()) << rig.emulator.highest_grip_n();
    EXPECT_NEAR(rig.force_n, rig.emulator.grip_n(), 0.3);
    EXPECT_TRUE(rig.notes().empty());
}

TEST(AbilityHandDriver, GoesOnClosingInOtherModesOnlyUntilTheHandLeavesThem) {
    scene::AbilityHand hand;
    hand.drive = scene::VelocityDrive{.speed_deg_per_s = 60};
    Rig rig(hand, {.distance_mm = 1000});
    rig.steer = [] { return 1.0; };
    rig.run(500ms);
    rig.cut = true;
    const double before_deg = rig.position_deg;
    rig.run(2s);
    // 300 ms, and the motor's lag.
    EXPECT_NEAR(rig.position_deg - before_deg, 60 * 0.33, 3);
}

TEST(AbilityHandDriver, DoesNotCreepByZerosThatAreTakenAgainAndAgain) {
    Rig rig;
    for (int i = 0; i < 20; ++i) {
        rig.emulator.faults().pressing_n += 0.1;
        rig.driver.take_zero(wall_time(rig.now));
        rig.run(600ms);
    }
    EXPECT_GE(rig.force_n, 2 - 0.3 - 0.2) << "zero_drift_n, and the readings' noise";
    EXPECT_GT(rig.readings().zeros_refused, 10U);
}

TEST(AbilityHandDriver, GoesOnOverANoisyLine) {
    Rig rig({}, {.breaking_n = limit_n, .noise = {0.05, 0.05, 0.05, 0.05, 0.05}});
    rig.close_by_force();
    rig.run(3s);
    EXPECT_FALSE(rig.emulator.broken());
    EXPECT_GT(rig.emulator.grip_n(), 3);
    const HandReadings readings = rig.readings();
    EXPECT_GT(rig.emulator.damaged_replies(), 100U);
    EXPECT_GT(readings.unanswered, 100U);
    EXPECT_EQ(readings.replies + readings.unanswered, readings.commands)
        << "all but the last, and the first that read";
}

TEST(AbilityHandDriver, IgnoresRepliesThatNobodyAskedFor) {
    Rig rig;
    ability_hand::Reply reply{.mode = ability_hand::Mode::position};
    std::vector<std::byte> line;
    ability_hand::append_reply(reply, line);
    rig.driver.read(wall_time(rig.now), line, [](auto, auto) { ADD_FAILURE(); });
    EXPECT_EQ(rig.readings().implausible_replies, 1U);
    // Asked for, but with a finger where none can be.
    rig.driver.poll(wall_time(rig.now));
    line.clear();
    reply = {};
    reply.position_deg[2] = -60;
    ability_hand::append_reply(reply, line);
    rig.driver.read(wall_time(rig.now), line, [](auto, auto) { ADD_FAILURE(); });
    EXPECT_EQ(rig.readings().implausible_replies, 2U);
}

TEST(AbilityHandDriver, KeepsToTheEndsOfTheScene) {
    Rig rig({}, {.distance_mm = 1000});
    rig.steer = [] { return 1.0; };
    rig.run(3s);
    EXPECT_NEAR(rig.emulator.position_deg(0), 100, 1);
    EXPECT_NEAR(rig.emulator.position_deg(5), -80, 1);
    rig.steer = [] { return -1.0; };
    rig.run(3s);
    EXPECT_NEAR(rig.emulator.position_deg(0), 5, 1);
}

TEST(AbilityHandDriver, MeasuresFromASampleToTheCommandThatKnowsIt) {
    Rig rig;
    rig.steer = [] { return 0.0; };
    rig.run(1s);
    // A reply is known to the next command, a period of 2 ms less the 1 ms of the line later.
    const HandReadings readings = rig.readings();
    EXPECT_GT(readings.sample_to_command_p50, 0ms);
    EXPECT_LE(readings.sample_to_command_max, 2ms);
}

// While the decoder hangs, samples wait in a ring, which keeps the last 256; they are 2 ms apart. Then each
// waits for 20 ms.
TEST(AbilityHandDriver, MeasuresHowLongSamplesWaitForTheDecoder) {
    Rig rig;
    rig.steer = [] { return 0.0; };
    rig.decoder_lag = 10s;
    rig.run(1500ms);
    rig.decoder_lag = 20ms;
    rig.run(2s);
    const HandReadings readings = rig.readings();
    EXPECT_GE(readings.sample_to_command_p50, 20ms);
    EXPECT_LE(readings.sample_to_command_p50, 23ms);
    EXPECT_GE(readings.sample_to_command_max, 505ms);
    EXPECT_LE(readings.sample_to_command_max, 520ms);
}

}  // namespace
}  // namespace afferent
