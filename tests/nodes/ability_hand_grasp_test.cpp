// The grasp of examples/ability_hand.txtpb from sensors to motors, in virtual time: an emulated hand, its
// driver, the coprocessor, a link, the hand node. And what goes wrong in the middle of it.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "afferent/hand/ability_hand_emulator.hpp"
#include "afferent/nodes/ability_hand_driver.hpp"
#include "tests/long_runs.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

using Settings = std::vector<Setting>;

// Driver and emulated hand at the ends of a line.
class EmulatedHand final : public HandDevice {
  public:
    EmulatedHand(const Plan& plan, MonotonicTime now)
        : driver(ability_hand_driver_parameters(plan), now),
          emulator({.baud = plan.scene.hand.ability_hand->baud,
                    .stiffness_n_per_mm = plan.scene.hand.object.stiffness_n_per_mm,
                    .distance_mm = plan.scene.hand.object.distance_mm,
                    .breaking_n = plan.scene.gain.limit_n}),
          began_(now) {}

    void start(std::function<void()>) override {}
    void command(const DeviceCommand& command) noexcept override { driver.follow(command); }
    const HandScan* next_scan() override {
        if (taken_) scans_.pop_front();
        taken_ = !scans_.empty();
        if (taken_ && lie) lie(scans_.front());
        return taken_ ? &scans_.front() : nullptr;
    }
    std::optional<std::string> next_note() override { return driver.next_note(); }
    const HandReadings& readings() override { return driver.readings(now_); }
    std::uint64_t dropped_scans() const noexcept override { return 0; }
    void take_zero() noexcept override { driver.take_zero(now_); }

    // Does what is due on the line, and says when something is again.
    MonotonicTime poll(MonotonicTime now) {
        now_ = now;
        const TimePoint time = scene_start + (now - began_);
        emulator.advance(time);
        if (const auto request = driver.poll(now); !request.empty() && !cut) emulator.receive(time, request);
        std::vector<std::byte> reply;
        emulator.send(time, reply);
        if (!cut)
            driver.read(now, reply, [this](MonotonicTime at, std::span<const double> forces_n) {
                scans_.push_back({at, {forces_n.begin(), forces_n.end()}});
            });
        MonotonicTime wake = driver.wake();
        if (const auto due = emulator.next_reply()) wake = std::min(wake, began_ + (*due - scene_start));
        return wake;
    }

    AbilityHandDriver driver;
    AbilityHandEmulator emulator;
    bool cut = false;
    void (*lie)(HandScan&) = nullptr;

  private:
    MonotonicTime began_;
    MonotonicTime now_ = began_;
    std::deque<HandScan> scans_;
    bool taken_ = false;
};

struct Grasp {
    explicit Grasp(const Settings& settings = {})
        : nodes(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/ability_hand.txtpb").with(settings)) {
        auto device = std::make_unique<EmulatedHand>(nodes.plan, nodes.now);
        hand = device.get();
        nodes.beside = [this](MonotonicTime now) { return hand->poll(now); };
        nodes.start_hand(nodes.links.listener(), {}, std::move(device));
        nodes.start_coprocessor();
    }
    void run(Duration span) { nodes.run_for(span); }
    double highest_n() const { return hand->emulator.highest_grip_n(); }
    HandNode::Report report() const { return nodes.hand.node->report(); }

    TwoNodes nodes;
    EmulatedHand* hand;
};

TEST(AbilityHandGrasp, HoldsWhatWouldBreak) {
    Grasp grasp;
    grasp.run(4s);
    EXPECT_FALSE(grasp.hand->emulator.broken()) << grasp.highest_n();
    EXPECT_GT(grasp.hand->emulator.grip_n(), 5);
    const HandNode::Report report = grasp.report();
    EXPECT_EQ(report.state, GripState::operating);
    EXPECT_EQ(report.freezes, 0U);
    EXPECT_GT(report.received.events, 500U);
    EXPECT_LE(report.hand->sample_to_command_p99, 4ms);
    // The last estimate before the hold ends, beside what the object feels.
    EXPECT_NEAR(grasp.nodes.hand.steps.back()[1], grasp.hand->emulator.grip_n(), 1);
}

TEST(AbilityHandGrasp, IsHarderWithoutFeedback) {
    Grasp with;
    with.run(4s);
    Grasp without({Setting::from("gain.onset_n=100"), Setting::from("gain.limit_n=101")});
    without.run(4s);
    // There the lead of the targets is all that bounds it.
    EXPECT_GT(without.highest_n(), 1.25 * with.highest_n());
}

// What goes wrong in the middle of a grasp, at several times of it.
struct HandFault {
    const char* name;
    void (*happen)(EmulatedHand&);
    bool silences = false;  // no reply comes any more
    double felt = 1;        // the part of the force that is felt all the same
    bool obeys = true;      // commands go on reaching the hand
};

const char* const drives[] = {"position={}", "velocity={}", "current={current_a: 0.3}",
                              "duty={duty_percent: 40}"};

class AbilityHandFault : public testing::TestWithParam<HandFault> {};

TEST_P(AbilityHandFault, GripsNoHarderThanWithoutItAndIsSafeInTime) {
    const HandFault& fault = GetParam();
    for (const char* const drive : drives) {
        const Settings settings{Setting::from(std::string("hand.ability_hand.") + drive)};
        // What no command reaches stops by itself in this mode only.
        if (!fault.obeys && drive != drives[0]) continue;
        Grasp whole(settings);
        whole.run(4s);
        ASSERT_FALSE(whole.hand->emulator.broken()) << whole.highest_n();
        ASSERT_GT(whole.highest_n(), 2);
        for (const Duration when : {1150ms, 1300ms, 1500ms, 2500ms}) {
            SCOPED_TRACE(drive + std::string(" at ") + std::to_string(Milliseconds(when).count()) + " ms");
            Grasp grasp(settings);
            grasp.run(when);
            fault.happen(*grasp.hand);
            const LinkTiming& timing = grasp.nodes.plan.timing;
            grasp.run(timing.freeze + timing.safe + 5ms);
            if (fault.silences) {
                EXPECT_EQ(grasp.report().state, GripState::safe);
                EXPECT_FALSE(grasp.report().hand->answering);
            }
            grasp.run(4s - when);
            // The readings' noise, through the gain.
            EXPECT_LE(grasp.highest_n(), whole.highest_n() / fault.felt + 0.3);
            EXPECT_FALSE(grasp.hand->emulator.broken());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    All, AbilityHandFault,
    testing::Values(
        HandFault{.name = "CableCut",
                  .happen = [](EmulatedHand& hand) { hand.cut = true; },
                  .silences = true,
                  .obeys = false},
        HandFault{.name = "HandFrozen",
                  .happen = [](EmulatedHand& hand) { hand.emulator.faults().frozen = true; },
                  .silences = true,
                  .obeys = false},
        HandFault{.name = "Nonsense",
                  .happen = [](EmulatedHand& hand) { hand.emulator.faults().nonsense = true; },
                  .silences = true},
        HandFault{.name = "SensorSaturated",
                  .happen =
                      [](EmulatedHand& hand) {
                          hand.emulator.faults().stuck_counts[24] = ability_hand::most_counts;
                      }},
        // The thumb's first sensor has 15 % of the force.
        HandFault{.name = "SensorDead",
                  .happen = [](EmulatedHand& hand) { hand.emulator.faults().stuck_counts[24] = 0; },
                  .felt = 0.85},
        HandFault{.name = "ZeroTakenWhileTouched", .happen = [](EmulatedHand& hand) { hand.take_zero(); }}),
    [](const auto& each) { return std::string(each.param.name); });

// What a hand says that does not keep to its interface: the forces of a grasp must not go unfelt.
TEST(AbilityHandGrasp, GoesSafeByScansThatCannotBe) {
    const struct {
        const char* said;
        void (*lie)(HandScan&);
    } lies[] = {
        {"29 forces of 30 elements", [](HandScan& scan) { scan.forces_n.resize(29); }},
        {"0 forces of 30 elements", [](HandScan& scan) { scan.forces_n.clear(); }},
        {"a force that is negative or no number", [](HandScan& scan) { scan.forces_n[7] = std::nan(""); }},
        {"a force that is negative or no number",
         [](HandScan& scan) {
             for (double& force_n : scan.forces_n) force_n = -force_n;
         }},
        {"a time that is still to come", [](HandScan& scan) { scan.at += 1s; }}};
    for (const auto& [said, lie] : lies) {
        Grasp grasp;
        grasp.run(1200ms);
        const double before_n = grasp.hand->emulator.grip_n();
        grasp.hand->lie = lie;
        grasp.run(2s);
        EXPECT_EQ(grasp.report().state, GripState::safe) << said;
        EXPECT_GT(grasp.report().dropped_scans, 900U) << said;
        EXPECT_EQ(grasp.nodes.hand.session[1], std::string("scans of the hand are not used: ") + said);
        // It closes on for freeze_ms, at 120 degrees a second.
        EXPECT_LE(grasp.hand->emulator.highest_grip_n(), before_n + 7) << said;
        EXPECT_FALSE(grasp.hand->emulator.broken()) << said;
    }
}

TEST(AbilityHandGrasp, GoesOnByItsLastVelocityUntilTheHandLeavesItsMode) {
    double furthest = 0;  // as a part of what the plan says
    for (const Duration when : {1150ms, 1500ms, 2000ms}) {
        Grasp grasp(
            {Setting::from("hand.ability_hand.velocity={}"), Setting::from("hand.user.close_for_s=4")});
        grasp.run(when);
        const double before_deg = grasp.hand->emulator.position_deg(0);
        grasp.hand->cut = true;
        grasp.run(2s);
        const auto& hand = *grasp.nodes.plan.scene.hand.ability_hand;
        const double most_deg = std::get<scene::VelocityDrive>(hand.drive).speed_deg_per_s *
                                seconds(ability_hand::leaves_mode_after);
        furthest = std::max(furthest, (grasp.hand->emulator.position_deg(0) - before_deg) / most_deg);
    }
    EXPECT_GT(furthest, 0.5);
    EXPECT_LT(furthest, 1.1) << "what the motor catches up";
}

TEST(AbilityHandGrasp, GoesOnAfterALineThatWasSilentForLong) {
    const Duration silence = long_runs ? Duration(1000s) : Duration(20s);
    Grasp grasp({Setting::from("duration_s=1100"), Setting::from("hand.emg_rate_hz=200"),
                 Setting::from("hand.user.close_at_s=0.5")});
    grasp.run(1s);
    const double before_deg = grasp.hand->emulator.position_deg(0);
    grasp.hand->cut = true;
    grasp.run(silence);
    EXPECT_EQ(grasp.report().state, GripState::safe);
    EXPECT_NEAR(grasp.hand->emulator.position_deg(0), before_deg, 6);
    EXPECT_FALSE(grasp.hand->emulator.driven());
    EXPECT_LT(grasp.nodes.hand.session.size(), 10U) << "what is said of it does not grow";
    grasp.hand->cut = false;
    grasp.run(5s);
    EXPECT_TRUE(grasp.report().hand->answering);
    EXPECT_EQ(grasp.report().state, GripState::operating);
}

}  // namespace
}  // namespace afferent
