// What a node says of itself while it runs, and a run once it is over.
#include "afferent/nodes/run_summary.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/nodes/chip_reader.hpp"
#include "afferent/nodes/output_thread.hpp"
#include "afferent/nodes/replay.hpp"
#include "tests/counts_nothing.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

std::string text(Summary summary, const char* key) {
    const std::string* const found = summary[key].text();
    return found ? *found : "";
}

bool interrupted(Summary summary) { return std::get<bool>(summary["interrupted"].value()); }

TEST(Reports, CountFromNothing) {
    EXPECT_TRUE(counts_nothing<ChipComparison::Counts>());
    EXPECT_TRUE(counts_nothing<ReplayCounts>());
    EXPECT_TRUE(counts_nothing<LinkTotals>());
    EXPECT_TRUE(counts_nothing<OutputLosses>());
    EXPECT_TRUE(counts_nothing<CoprocessorNode::Report::Counts>());
    const ChipReport chip;
    for (const std::uint64_t count : {chip.refused_bytes, chip.packets, chip.refused_packets,
                                      chip.unknown_packets, chip.implausible_packets, chip.gaps,
                                      chip.lost_events, chip.late_events, chip.beginnings, chip.clock_jumps})
        EXPECT_EQ(count, 0U);
    EXPECT_EQ(chip.clock_ppm, 0);
    const CoprocessorNode::Report coprocessor;
    for (const std::uint64_t count :
         {coprocessor.sessions, coprocessor.broken_sessions, coprocessor.interrupted_sessions})
        EXPECT_EQ(count, 0U);
    EXPECT_EQ(coprocessor.times_begun, 1U);
    const HandNode::Report hand;
    for (const std::uint64_t count :
         {hand.sessions, hand.broken_sessions, hand.interrupted_sessions, hand.refused_peers, hand.feed_bytes,
          hand.freezes, hand.safe_states, hand.dropped_packets, hand.dropped_scans, hand.unwritten_steps,
          hand.lost_events})
        EXPECT_EQ(count, 0U);
    EXPECT_FALSE(hand.real_time_priority);
    const HandReadings device;
    for (const std::uint64_t count :
         {device.commands, device.replies, device.unanswered, device.refused_frames, device.lost_lines,
          device.implausible_replies, device.zeros_taken, device.zeros_refused,
          std::uint64_t{device.motor_count}, std::uint64_t{device.sensor_count},
          std::uint64_t{device.temperature_status}})
        EXPECT_EQ(count, 0U);
    EXPECT_FALSE(device.answering || device.driven);
    EXPECT_EQ(device.motors[0].position_deg, 0);
    EXPECT_EQ(device.motors[0].current_a, 0);
    EXPECT_EQ(DeviceCommand().command, 0);
    const GripReport grip;
    for (const std::uint64_t count :
         {grip.next_step, grip.sessions, grip.freezes, grip.safe_states, grip.late_packets,
          grip.dropped_packets, grip.dropped_scans, grip.lost_steps})
        EXPECT_EQ(count, 0U);
    EXPECT_FALSE(grip.begun || grip.at_end || grip.stopped || grip.spent);
}

using Numbers = std::vector<std::pair<const char*, double>>;

void expect_numbers(const Summary& summary, const Numbers& expected) {
    for (const auto& [key, value] : expected) {
        ASSERT_NE(summary.find(key), nullptr) << key;
        EXPECT_EQ(summary.find(key)->number(), value) << key;
    }
}

// Has a report, each number of which is another.
class ReportingHand final : public HandNode {
  public:
    explicit ReportingHand(const Plan& plan) : plan_(plan) {
        report_.sessions = 1;
        report_.broken_sessions = 2;
        report_.interrupted_sessions = 3;
        report_.refused_peers = 4;
        report_.received = {.packets = 5,
                            .events = 6,
                            .gaps = 7,
                            .unknown = {},
                            .lost_events = 8,
                            .out_of_order = 9,
                            .refused = 10,
                            .late = 11,
                            .stale = 12};
        report_.link = {13, 14, 15, 16, 17, 18, 19};
        report_.feed_bytes = 20;
        report_.freezes = 21;
        report_.safe_states = 22;
        report_.state = GripState::frozen;
        report_.reason = "silence";
        report_.real_time_priority = true;
        report_.dropped_packets = 23;
        report_.dropped_scans = 24;
        report_.unwritten_steps = 25;
        report_.lost_events = 26;
        report_.hand.emplace();
        report_.hand->commands = 27;
        report_.hand->replies = 28;
        report_.hand->unanswered = 29;
        report_.hand->refused_frames = 30;
        report_.hand->implausible_replies = 31;
        report_.hand->lost_lines = 32;
        report_.hand->zeros_taken = 33;
        report_.hand->zeros_refused = 34;
        report_.hand->sample_to_command_p50 = 35ms;
        report_.hand->sample_to_command_p99 = 36ms;
        report_.hand->sample_to_command_max = 37ms;
        grip_.step_lateness = {38ms, 39ms, 40ms};
        grip_.last_step.estimate = {.force_n = 41, .sigma_n = 42, .left_out = 43, .doubt = Doubt::saturated};
        grip_.last_step.gain = 0.44;
        pacer_.emplace(MonotonicTime());
        pacer_->did(scene_start, MonotonicTime(45ms));
    }
    void start() override {}
    std::optional<MonotonicTime> poll() override { return std::nullopt; }
    void interrupt() override {}
    void acknowledge() override {}
    void take_zero() override {}
    void write() override {}
    std::size_t waiting_records() const noexcept override { return 0; }
    std::vector<std::string> output_notices() const override { return {}; }
    std::uint64_t lost_steps() const noexcept override { return 0; }
    Result<void> close() override { return success(); }
    const std::optional<std::string>& failure() const noexcept override { return failure_; }
    std::string address() const override { return ""; }
    const Plan& plan() const noexcept override { return plan_; }
    TimePoint at() const noexcept override { return scene_start + 46s; }
    const HandSession* session() const noexcept override { return nullptr; }
    const std::optional<Pacer>& pacer() const noexcept override { return pacer_; }
    const GripReport& grip() const noexcept override { return grip_; }
    Report report() const override { return report_; }
    const std::vector<std::string>& said_of_emg() const noexcept override { return said_; }

  private:
    const Plan& plan_;
    Report report_;
    GripReport grip_;
    std::optional<Pacer> pacer_;
    std::optional<std::string> failure_;
    std::vector<std::string> said_{"the EMG is weak"};
};

TEST(SummaryOf, AHandHasEachNumberOfItsReport) {
    const Plan plan =
        make_plan(Scene::from_text("name: 'mine' seed: 47 duration_s: 46 link { tcp {} } decoder { filter {} "
                                   "} output { live_events {} }"));
    const ReportingHand hand(plan);
    Summary summary = summary_of(hand);
    expect_numbers(summary, {{"seed", 47},
                             {"until_s", 46},
                             {"sessions", 1},
                             {"broken_sessions", 2},
                             {"interrupted_sessions", 3},
                             {"refused_peers", 4},
                             {"packets", 5},
                             {"events", 6},
                             {"gaps", 7},
                             {"lost_events", 8},
                             {"late_packets", 11},
                             {"stale_packets", 12},
                             {"bytes_sent", 13},
                             {"bytes_received", 14},
                             {"checksum_failures", 16},
                             {"refused_frames", 17},
                             {"forged_datagrams", 18},
                             {"repeated_datagrams", 19},
                             {"feed_bytes", 20},
                             {"freezes", 21},
                             {"safe_states", 22},
                             {"dropped_packets", 23},
                             {"dropped_scans", 24},
                             {"unwritten_steps", 25},
                             {"lost_live_events", 26},
                             {"step_lateness_p50_ms", 38},
                             {"step_lateness_p99_ms", 39},
                             {"step_lateness_max_ms", 40},
                             {"left_out_afferents", 43},
                             {"missed_deadlines", 1},
                             {"worst_lag_ms", 45}});
    expect_numbers(summary["hand"], {{"commands", 27},
                                     {"replies", 28},
                                     {"unanswered", 29},
                                     {"refused_frames", 30},
                                     {"implausible_replies", 31},
                                     {"lost_lines", 32},
                                     {"zeros_taken", 33},
                                     {"zeros_refused", 34},
                                     {"sample_to_command_p50_ms", 35},
                                     {"sample_to_command_p99_ms", 36},
                                     {"sample_to_command_max_ms", 37}});
    EXPECT_EQ(text(summary, "side"), "hand");
    EXPECT_EQ(text(summary, "scene"), "mine");
    EXPECT_TRUE(std::get<bool>(summary["complete"].value()));
    EXPECT_TRUE(std::get<bool>(summary["real_time_priority"].value()));
    ASSERT_EQ(summary["notes"].list().size(), 1U);
    EXPECT_EQ(*summary["notes"].list()[0].text(), "the EMG is weak");
    // For `force_error_*` there is a place, and nothing is known.
    for (const char* const unknown : {"force_error_rms_n", "force_error_max_n"}) {
        ASSERT_NE(summary.find(unknown), nullptr);
        EXPECT_FALSE(summary[unknown].number());
    }
}

TEST(StatusOf, AHandHasTheNumbersOfItsReport) {
    const Plan plan =
        make_plan(Scene::from_text("name: 'mine' duration_s: 50 link { tcp {} } decoder { filter {} }"));
    Summary status = status_of(ReportingHand(plan));
    expect_numbers(status, {{"at_s", 46},
                            {"sessions", 1},
                            {"packets", 5},
                            {"events", 6},
                            {"gaps", 7},
                            {"lost_events", 8},
                            {"late_packets", 11},
                            {"stale_packets", 12},
                            {"bytes", 14},
                            {"checksum_failures", 16},
                            {"refused_frames", 17},
                            {"forged_datagrams", 18},
                            {"force_n", 41},
                            {"sigma_n", 42},
                            {"gain", 0.44},
                            {"left_out_afferents", 43}});
    EXPECT_EQ(text(status, "scene"), "mine");
    EXPECT_EQ(text(status, "session"), "none");
    EXPECT_EQ(text(status, "grip_state"), "frozen");
    EXPECT_EQ(text(status, "reason"), "silence");
    EXPECT_EQ(text(status, "doubt"), "saturated");
    EXPECT_EQ(status.find("last_refusal"), nullptr);
    EXPECT_EQ(text(summary_of(ReportingHand(plan)), "scene"), "mine");
    Summary summary = summary_of(ReportingHand(plan));
    EXPECT_FALSE(std::get<bool>(summary["complete"].value())) << "four seconds are missing";
    EXPECT_EQ(summary.find("lost_live_events"), nullptr) << "the scene has no such output";
}

// Has the neurons of another, and a report of its own.
class ReportingCoprocessor final : public CoprocessorNode {
  public:
    explicit ReportingCoprocessor(const CoprocessorNode& other, std::uint64_t times_begun) : other_(other) {
        report_.sessions = 1;
        report_.broken_sessions = 2;
        report_.interrupted_sessions = 3;
        report_.link = {13, 14, 15, 16, 17, 18, 19};
        report_.counts = {20, 21, 22, 23, 24};
        report_.since_begin.packet_bytes = 25;
        report_.times_begun = times_begun;
        report_.hand_gain = 0.5;
    }
    void start() override {}
    std::optional<MonotonicTime> poll() override { return std::nullopt; }
    Result<void> push(const Scan&) override { return success(); }
    void interrupt() override {}
    void fail(const std::string&) override {}
    Result<void> close() override { return success(); }
    const std::optional<std::string>& failure() const noexcept override { return failure_; }
    const Plan& plan() const noexcept override { return other_.plan(); }
    TimePoint at() const noexcept override { return scene_start + 7s; }
    CoprocessorEnd& link_end() noexcept override { return const_cast<CoprocessorEnd&>(other_.link_end()); }
    const CoprocessorEnd& link_end() const noexcept override { return other_.link_end(); }
    const CoprocessorSession* session() const noexcept override { return nullptr; }
    const std::optional<Pacer>& pacer() const noexcept override { return pacer_; }
    Report report() const override { return report_; }

  private:
    const CoprocessorNode& other_;
    Report report_;
    std::optional<Pacer> pacer_;
    std::optional<std::string> failure_;
};

TEST(SummaryOf, ACoprocessorHasEachNumberOfItsReport) {
    TwoNodes two(press("bus {}", 20));
    two.start();
    two.run_for(1s);
    const CoprocessorEnd& end = two.coprocessor.node->link_end();
    const Numbers of_neurons{{"samples", static_cast<double>(end.samples())},
                             {"clipped_samples", 0},
                             {"late_scans", 0},
                             {"events", static_cast<double>(end.events())},
                             {"packets", static_cast<double>(end.packetizer()->packets())},
                             {"raw_sample_bytes", static_cast<double>(end.raw_sample_bytes())},
                             {"bus_events", static_cast<double>(end.bus()->counts().events)},
                             {"bus_collisions", static_cast<double>(end.bus()->counts().collisions)},
                             {"bus_dropped", 0},
                             {"link_bytes", 25}};
    const Numbers of_node{{"until_s", 7},
                          {"sessions", 1},
                          {"broken_sessions", 2},
                          {"interrupted_sessions", 3},
                          {"bytes_sent", 13},
                          {"bytes_received", 14},
                          {"dropped_packets", 15},
                          {"checksum_failures", 16},
                          {"refused_frames", 17},
                          {"forged_datagrams", 18},
                          {"repeated_datagrams", 19},
                          {"missed_deadlines", 0}};
    ASSERT_GT(end.samples(), 0U);
    ASSERT_GT(end.raw_sample_bytes(), 0U);
    Summary once = summary_of(ReportingCoprocessor(*two.coprocessor.node, 1));
    EXPECT_EQ(text(once, "side"), "coprocessor");
    expect_numbers(once, of_neurons);
    expect_numbers(once, of_node);
    EXPECT_EQ(once.find("times_begun"), nullptr);
    // Nine fire together, and leave the bus one after the other, in cycles of 0.1 µs.
    EXPECT_NEAR(once["bus_delay_p50_us"].number().value(), 0.5, 1e-12);
    EXPECT_NEAR(once["bus_delay_p99_us"].number().value(), 0.9, 1e-12);
    EXPECT_NEAR(once["bus_delay_max_us"].number().value(), 0.9, 1e-12);

    Summary twice = summary_of(ReportingCoprocessor(*two.coprocessor.node, 2));
    expect_numbers(twice["since_last_begin"], of_neurons);
    expect_numbers(twice, of_node);
    expect_numbers(twice, {{"times_begun", 2},
                           {"samples", 20},
                           {"events", 21},
                           {"packets", 22},
                           {"raw_sample_bytes", 23},
                           {"link_bytes", 24}});

    expect_numbers(status_of(ReportingCoprocessor(*two.coprocessor.node, 1)), {{"at_s", 7},
                                                                               {"sessions", 1},
                                                                               {"samples", 20},
                                                                               {"events", 21},
                                                                               {"packets", 22},
                                                                               {"bytes", 13},
                                                                               {"bytes_received", 14},
                                                                               {"dropped_packets", 15},
                                                                               {"refused_frames", 17},
                                                                               {"queued_bytes", 0},
                                                                               {"hand_gain", 0.5}});
}

TEST(StatusOf, ANodeSaysHowItsSessionAndTheGripStand) {
    TwoNodes two(press("", 20));
    two.start();
    two.run_for(1s);
    Summary ours = status_of(*two.coprocessor.node);
    EXPECT_EQ(text(ours, "session"), "open");
    EXPECT_EQ(ours["sessions"].number(), 1);
    EXPECT_EQ(ours.find("last_refusal"), nullptr) << "nothing was refused";
    EXPECT_GT(ours["bytes"].number(), 100) << "of the session that is open, too";
    EXPECT_EQ(text(status_of(*two.hand.node), "grip_state"), "operating");
    two.kill_coprocessor();
    two.run_for(80ms);
    EXPECT_EQ(text(status_of(*two.hand.node), "grip_state"), "frozen");
    two.run_for(100ms);
    Summary theirs = status_of(*two.hand.node);
    EXPECT_EQ(text(theirs, "grip_state"), "safe");
    EXPECT_EQ(text(theirs, "session"), "none");
}

// Only the filter leaves afferents out, so that no other decoder has the number.
TEST(StatusOf, AHandTellsHowManyAfferentsItsFilterLeavesOut) {
    for (const bool filter : {true, false}) {
        TwoNodes two(press("", 20, filter ? "decoder { filter {} }" : "decoder { sliding_window {} }"));
        two.start();
        two.run_for(1s);
        Summary status = status_of(*two.hand.node);
        EXPECT_EQ(status.find("left_out_afferents") != nullptr, filter);
        if (filter) {
            EXPECT_EQ(status["left_out_afferents"].number(), 0);
        }
    }
}

TEST(SummaryOf, NodesOnALinkTellOfTheBusAndHowLateStepsRun) {
    TwoNodes two(press("bus {}", 20));
    two.start();
    two.run_for(1s);
    Summary ours = summary_of(*two.coprocessor.node);
    EXPECT_GT(ours["bus_events"].number(), 100);
    EXPECT_EQ(ours["bus_events"].number(), ours["events"].number());
    Summary theirs = summary_of(*two.hand.node);
    EXPECT_NE(theirs.find("step_lateness_p50_ms"), nullptr);
    EXPECT_NE(theirs.find("missed_deadlines"), nullptr);
}

TEST(SummaryOf, ACoprocessorTellsOfSamplesThatItHasClipped) {
    TwoNodes two(press(
        "", 20, "every_patch { sensor { full_scale_n: 0.1 } } gain { accept_unreachable_limit: true }"));
    two.start();
    two.run_for(1s);
    const Summary ours = summary_of(*two.coprocessor.node);
    ASSERT_NE(ours.find("notes"), nullptr);
    EXPECT_NE(ours.find("notes")->list().front().text()->find("beyond full scale"), std::string::npos)
        << *ours.find("notes")->list().front().text();
}

TEST(SummaryOf, ARunHasTheCountsOfItsParts) {
    const Plan plan = make_plan(Scene::from_text(
        "name: 'mine' seed: 5 duration_s: 3 record { picture: false } decoder { filter {} } "
        "source { profile { point { time_s: 0 force_n: 5 } } } "
        "link { tcp {} channel { loss: 0.1 corrupt: 0.1 reorder: 0.1 jitter_ms: 20 fifo_events: 40 "
        "bandwidth_bps: 3e4 } bus {} }"));
    const auto run = whole_run(plan);
    const PacketCounts received = run->received();
    const ChannelCounts channel = run->channel()->counts();
    ASSERT_GT(channel.lost, 0U);
    ASSERT_GT(received.gaps, 0U);
    ASSERT_GT(received.lost_events, 0U);
    ASSERT_GT(run->checksum_failures(), 0U);
    ForceError error;
    error.add(3, 0);
    error.add(4, 0);
    Summary summary = summary_of(*run, plan.end(), error, std::nullopt);
    expect_numbers(summary, {{"seed", 5},
                             {"duration_s", 3},
                             {"samples", 3 * 200.0 * plan.elements},
                             {"clipped_samples", 0},
                             {"late_scans", 0},
                             {"events", static_cast<double>(run->coprocessor().events())},
                             {"packets", static_cast<double>(run->packets())},
                             {"link_bytes", static_cast<double>(run->link_bytes())},
                             {"channel_lost", static_cast<double>(channel.lost)},
                             {"channel_dropped", static_cast<double>(channel.dropped)},
                             {"gaps", static_cast<double>(received.gaps)},
                             {"lost_events", static_cast<double>(received.lost_events)},
                             {"late_packets", static_cast<double>(received.late)},
                             {"stale_packets", static_cast<double>(received.stale)},
                             {"out_of_order_packets", static_cast<double>(received.out_of_order)},
                             {"checksum_failures", static_cast<double>(run->checksum_failures())},
                             {"raw_sample_bytes", static_cast<double>(run->coprocessor().raw_sample_bytes())},
                             {"left_out_afferents", run->hand()->last_step().estimate.left_out},
                             {"force_error_rms_n", std::sqrt(12.5)},
                             {"force_error_max_n", 4},
                             {"missed_deadlines", 0}});
    EXPECT_EQ(text(summary, "scene"), "mine");
    EXPECT_EQ(text(summary, "safe_state"), run->safe_reason());
    EXPECT_NE(summary.find("bus_events"), nullptr);
    EXPECT_EQ(summary.find("acknowledgement_bytes"), nullptr);
    EXPECT_EQ(summary.find("lost_live_events"), nullptr);
}

TEST(SummaryOf, ARunThatReachedItsEndWasNotInterrupted) {
    const Plan plan = make_plan(Scene::from_text("duration_s: 0.1 record { picture: false }"));
    const auto run = whole_run(plan);
    EXPECT_FALSE(interrupted(summary_of(*run, plan.end(), {}, std::nullopt)));
    EXPECT_TRUE(interrupted(summary_of(*run, plan.end() - 1ns, {}, std::nullopt)));
}

}  // namespace
}  // namespace afferent
