#include "afferent/nodes/run.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/run_summary.hpp"
#include "afferent/runtime/spike_storm.hpp"
#include "bench/drives.hpp"
#include "bench/reference.hpp"
#include "tests/long_runs.hpp"
#include "tests/nodes/whole_run.hpp"
#include "tests/shared_data.hpp"

namespace afferent {
namespace {

struct Record {
    std::vector<Event> events;
    std::vector<ControllerStep> steps;
    std::uint64_t link_bytes = 0;
};

Record run(const Plan& plan) {
    Record record;
    const auto run =
        whole_run(plan, {.events =
                             [&](std::span<const Event> events) {
                                 record.events.insert(record.events.end(), events.begin(), events.end());
                             },
                         .step = [&](const ControllerStep& step) { record.steps.push_back(step); }});
    record.link_bytes = run->link_bytes();
    return record;
}

Record run(const std::string& text) { return run(make_plan(Scene::from_text(text))); }

void expect_equal(const Record& a, const Record& b) {
    EXPECT_EQ(a.events, b.events);
    ASSERT_EQ(a.steps.size(), b.steps.size());
    for (std::size_t i = 0; i < a.steps.size(); ++i) {
        ASSERT_EQ(a.steps[i].estimate.force_n, b.steps[i].estimate.force_n) << i;
        ASSERT_EQ(a.steps[i].gain, b.steps[i].gain) << i;
        ASSERT_EQ(a.steps[i].command, b.steps[i].command) << i;
    }
}

// All spikes of a neuron under its drives, to 50 digits.
std::vector<reference::Real> true_spikes(const NeuronDrive& drive, TimePoint end) {
    const reference::Neuron neuron(std::get<LifParameters>(drive.parameters));
    reference::State state = neuron.rest();
    std::vector<reference::Real> spikes;
    const auto at = [](TimePoint time) {
        return reference::Real((time - scene_start).count()) / 1'000'000'000;
    };
    reference::Real now = 0;
    for (std::size_t i = 0; i < drive.steps.size(); ++i) {
        const reference::Real until = at(i + 1 < drive.steps.size() ? drive.steps[i + 1].time : end);
        while (now < until) {
            const auto ahead = neuron.next_spike_s(state, drive.steps[i].drive_mv);
            if (!ahead || now + *ahead > until) {
                state = neuron.advance(state, drive.steps[i].drive_mv, until - now);
                now = until;
                break;
            }
            state = neuron.advance(state, drive.steps[i].drive_mv, *ahead);
            now += *ahead;
            neuron.fire(state);
            spikes.push_back(now);
        }
    }
    return spikes;
}

void expect_true_to_a_nanosecond(const Plan& plan) {
    const Record record = run(plan);
    EXPECT_FALSE(record.events.empty());
    const auto drives = record_drives(plan);
    ASSERT_TRUE(drives);
    std::vector<std::vector<double>> stamps_ns(plan.addresses);
    for (const Event& event : record.events)
        stamps_ns.at(event.address).push_back(static_cast<double>((event.time - scene_start).count()));
    for (Address address = 0; address < plan.addresses; ++address) {
        const auto truth = true_spikes(drives.value()[address], plan.end());
        ASSERT_EQ(stamps_ns[address].size(), truth.size()) << "address " << address;
        for (std::size_t k = 0; k < truth.size(); ++k) {
            // A stamp is the first whole nanosecond at which the spike has happened.
            const reference::Real off_ns = stamps_ns[address][k] - truth[k] * 1'000'000'000;
            ASSERT_LE(abs(off_ns), 1) << "address " << address << ", spike " << k;
        }
    }
}

constexpr const char* short_grasp = R"(
    duration_s: 2
    hand { user { close_at_s: 0.1 close_for_s: 0.8 hold_for_s: 0.6 open_for_s: 0.3 effort: 0.7 }
           object { distance_mm: 8 stiffness_n_per_mm: 1 } }
    link { tcp {} } )";

TEST(Run, IsTrueToANanosecondOnAGrasp) {
    Scene scene = Scene::from_text(short_grasp);
    if (!long_runs) scene.duration_s = 0.9;
    expect_true_to_a_nanosecond(make_plan(scene));
}

TEST(Run, IsTrueToANanosecondOnRecordedForce) {
    if (!long_runs) GTEST_SKIP() << "the 50 digits take minutes with sanitizers";
    Scene scene = Scene::from_text(R"(
        duration_s: 3 source { table { path: "grip.csv" } }
        patch { name: "grip" elements: 2 sensor { full_scale_n: 25 } })");
    for (const char* file : {"grip_human_1.csv", "grip_human_2.csv", "grip_human_3.csv"}) {
        const auto path = shared_data() / file;
        if (!std::filesystem::exists(path)) GTEST_SKIP() << "the recorded grip forces are not here";
        std::get<scene::Table>(scene.source).path = path.string();
        expect_true_to_a_nanosecond(make_plan(scene));
    }
}

TEST(Run, IsTheSameForTheSameSeedAndAnotherForAnother) {
    Scene scene = Scene::from_text(std::string(short_grasp) + "every_patch { sensor { noise_counts: 2 } }");
    const Record first = run(make_plan(scene));
    expect_equal(first, run(make_plan(scene)));
    scene.seed = 2;
    EXPECT_NE(run(make_plan(scene)).events, first.events);
}

TEST(Run, IsTheSameForAnyNumberOfThreads) {
    const std::string scene = R"(
        duration_s: 0.3 patch { name: "skin" elements: 6000 sensor { noise_counts: 3 full_scale_n: 0.02 } }
        source { profile { point { time_s: 0 force_n: 0 } point { time_s: 0.1 force_n: 12 } } } )";
    const Record one = run(scene + "runtime { threads: 1 }");
    EXPECT_GT(one.events.size(), 10'000U);
    for (const char* threads : {"runtime { threads: 2 }", "runtime { threads: 5 }"})
        expect_equal(one, run(scene + threads));
}

// By prediction and by a sweep, over a grasp with bursts and silence.
TEST(Run, IsTheSameByPredictionAndByASweepWithinANanosecond) {
    const std::string base =
        std::string(short_grasp) + "every_patch { sensor { noise_counts: 2 } neuron { form: ";
    for (const char* more : {"", " delta_g: 0", " tau_g_ms: 1000 delta_g: 0.5"}) {
        const Record sparse = run(base + "SPARSE" + more + " } }");
        const Record dense = run(base + "DENSE" + more + " } }");
        EXPECT_GT(sparse.events.size(), 100U);
        ASSERT_EQ(sparse.events.size(), dense.events.size()) << more;
        for (Address address = 0; address < 9; ++address) {
            const auto stamps = [&](const Record& record) {
                std::vector<TimePoint> times;
                for (const Event& event : record.events)
                    if (event.address == address) times.push_back(event.time);
                return times;
            };
            const auto a = stamps(sparse);
            const auto b = stamps(dense);
            ASSERT_EQ(a.size(), b.size()) << more;
            for (std::size_t i = 0; i < a.size(); ++i) ASSERT_LE(std::abs((a[i] - b[i]).count()), 1) << more;
        }
    }
}

// Packets change the resolution of time only; at a tick of 1 µs the estimate cannot tell.
TEST(Run, EstimatesTheSameWithPacketsAsWithout) {
    const std::string base = R"(duration_s: 2 source { profile { point { time_s: 0.5 force_n: 0 }
        point { time_s: 0.7 force_n: 8 } point { time_s: 1.6 force_n: 8 } point { time_s: 1.8 force_n: 0 } } } )";
    const Record handed_over = run(base + "link { tick_us: 1 }");
    for (const char* encoding : {"RICE", "FIXED_WIDTH", "PREDICTED"}) {
        const Record packets = run(base + "link { tcp {} tick_us: 1 encoding: " + encoding + " }");
        EXPECT_EQ(packets.events, handed_over.events);
        EXPECT_GT(packets.link_bytes, 0U);
        EXPECT_GT(packets.events.size(), 50U);
        ASSERT_EQ(packets.steps.size(), 2000U);
        ASSERT_EQ(handed_over.steps.size(), 2000U);
        for (std::size_t i = 0; i < packets.steps.size(); ++i)
            ASSERT_EQ(packets.steps[i].estimate.force_n, handed_over.steps[i].estimate.force_n)
                << seconds(packets.steps[i].time) << " s";
    }
    EXPECT_EQ(handed_over.link_bytes, 0U);
}

// Steady force, decoded after adaptation: what counting whole spikes leaves open is the decoder's own sigma.
TEST(Run, EstimatesASteadyForceWithinItsUncertainty) {
    for (const char* pooling : {"POOLED", "PER_NEURON"}) {
        for (const double force_n : {2.0, 5.0, 9.0}) {
            const Record record = run(
                "duration_s: 4 patch { name: 'a' elements: 9 } decoder { pooling: " + std::string(pooling) +
                " } source { profile { point { time_s: 0.1 } point "
                "{ time_s: 0.6 force_n: " +
                std::to_string(force_n) + " } } }");
            double sum = 0;
            double sigma = 0;
            int n = 0;
            for (const ControllerStep& step : record.steps) {
                if (step.time < scene_start + 2s) continue;
                EXPECT_EQ(step.true_force_n, force_n);
                sum += step.estimate.force_n;
                sigma += step.estimate.sigma_n;
                ++n;
            }
            // A newton is 5 Hz of 100 Hz at 20 N. One spike in two seconds is 0.1 N, and one in a window of
            // 60 ms is 3.3 N.
            EXPECT_NEAR(sum / n, force_n, 0.1) << pooling;
            EXPECT_GT(sigma / n, 0.1) << pooling;
            EXPECT_LT(sigma / n, 3.3) << pooling;
        }
    }
}

TEST(Run, ClosesUntilTheGainStopsIt) {
    const Record record = run(std::string(short_grasp));
    double largest = 0;
    double gain_at_largest = 1;
    for (const ControllerStep& step : record.steps) {
        if (step.true_force_n.value() <= largest) continue;
        largest = step.true_force_n.value();
        gain_at_largest = step.gain;
    }
    EXPECT_GT(largest, 1);
    EXPECT_LT(gain_at_largest, 0.5);
}

// Under doubt, here a fifth of the packets, the hand that goes by an upper bound presses less.
TEST(Run, CrushesLessByAnUpperBoundOfTheForce) {
    const std::string doubtful =
        std::string(short_grasp) + "gain { limit_n: 8 shape: CONTINUOUS upper_bound_sigmas: ";
    const auto pressed_n = [&](const std::string& sigmas) {
        Scene scene = Scene::from_text(doubtful + sigmas + " }");
        scene.link.heartbeat_ms = 5;
        scene.link.channel.emplace().loss = 0.2;
        double largest_n = 0;
        for (const ControllerStep& step : run(make_plan(scene)).steps)
            largest_n = std::max(largest_n, step.true_force_n.value());
        return largest_n;
    };
    const double by_mean_n = pressed_n("0");
    const double by_bound_n = pressed_n("2");
    EXPECT_LT(by_bound_n, 0.9 * by_mean_n);
    EXPECT_GT(by_bound_n, 1) << "it still closes";
}

// At the limit of 5 N an adapted afferent fires four times a second: windows are empty most of the time.
TEST(Run, DoesNotCloseBetweenTwoSpikesOfASlowAfferent) {
    for (const char* decoder : {"sliding_window {}", "exponential {}"}) {
        const Scene scene = Scene::from_text(
            "duration_s: 6 patch { name: 'grip' elements: 1 sensor { full_scale_n: 25 } "
            "neuron { tuning { rate: STEADY rate_hz: 4 force_n: 5 begin_force_n: 0.3 } } } "
            "source { simulated_hand {} } hand { motor { force_limit_n: 60 } } "
            "gain { onset_n: 1 lambda_n: 2 limit_n: 5 accept_unreachable_limit: true } decoder { " +
            std::string(decoder) + " }");
        double largest_n = 0;
        for (const ControllerStep& step : run(make_plan(scene)).steps)
            largest_n = std::max(largest_n, step.true_force_n.value());
        EXPECT_LT(largest_n, 5) << decoder;
        EXPECT_GT(largest_n, 1) << decoder << ": it does close";
    }
}

// Sensors that end below the limit: beyond their full scale it is only its momentum that closes the hand.
TEST(Run, ClosesNoFurtherThanItsMomentumWhereSensorsAreAtFullScale) {
    for (const char* decoder : {"window_ms: 60", "window_ms: 60 pooling: PER_NEURON", "exponential {}",
                                "interval {}", "inversion {}"}) {
        Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/paper.txtpb");
        scene.decoder = Scene::from_text(std::string("decoder { ") + decoder + " }").decoder;
        scene.patches.front().sensor.full_scale_n = 8;
        const Record record = run(make_plan(scene));
        const scene::Motor& motor = scene.hand.motor;
        double largest_n = 0;
        for (const ControllerStep& step : record.steps)
            largest_n = std::max(largest_n, step.true_force_n.value());
        // At full speed, which its motor loses with its time constant.
        const double momentum_n =
            scene.hand.object.stiffness_n_per_mm * motor.speed_mm_per_s * motor.time_constant_ms / 1000;
        EXPECT_LE(largest_n, scene.patches.front().sensor.full_scale_n + momentum_n) << decoder;
        EXPECT_GT(largest_n, 1) << decoder << ": it does close";
    }
}

TEST(Run, EndsWhereANeuronFiresWithoutBounds) {
    const Plan plan = make_plan(Scene::from_text(R"(
        patch { name: "hot" elements: 1 encoder { sustained { gain_mv_per_n: 1 bias_mv: 1e6 } } }
        runtime { spikes_per_window: 100 } record { force: false picture: false }
        source { profile { point { force_n: 0 } } } )"));
    auto opened = Run::open(plan, {});
    ASSERT_TRUE(opened);
    try {
        while (!opened.value()->done()) ASSERT_TRUE(opened.value()->do_next());
        FAIL() << "no storm";
    } catch (const SpikeStormError& storm) {
        EXPECT_EQ(storm.address(), 0U);
        EXPECT_NE(std::string(storm.what()).find("bias_mv 1e+06"), std::string::npos) << storm.what();
    }
}

// A frame has a length, a position of three bytes, a payload with two bytes before it, and a CRC of four.
TEST(Run, CountsWhatTheRawSamplesWouldTake) {
    for (const auto& [elements, bytes] : {std::pair(1, 1 + 3 + 2 + 2 + 4), {5, 1 + 3 + 2 + 8 + 4}}) {
        const Plan plan = make_plan(Scene::from_text(
            "duration_s: 1 link { tcp {} } record { picture: false } patch { name: 'a' elements: " +
            std::to_string(elements) + " } source { profile { point { force_n: 1 } } }"));
        EXPECT_EQ(value_or_throw(Run::open(plan, {}))->coprocessor().raw_sample_bytes(), 0U);
        const auto run = whole_run(plan);
        EXPECT_EQ(run->coprocessor().raw_sample_bytes(), 200U * static_cast<unsigned>(bytes)) << elements;
    }
}

// All samples of one time go in one frame: 5 of 12 bits in 8 bytes, or 3 in 5 where the other patch has none.
TEST(Run, CountsRawSamplesOfSeveralPatchesTogether) {
    const Plan plan = make_plan(Scene::from_text(
        "duration_s: 1 link { tcp {} } record { picture: false } patch { name: 'a' elements: 3 } "
        "patch { name: 'b' elements: 2 sensor { rate_hz: 100 } } source { profile { point { force_n: 1 } } "
        "}"));
    EXPECT_EQ(whole_run(plan)->coprocessor().raw_sample_bytes(),
              100U * (1U + 3 + 2 + 8 + 4) + 100U * (1U + 3 + 2 + 5 + 4));
}

TEST(Run, TellsItsPaceInTheSummary) {
    const Plan plan = make_plan(Scene::from_text("duration_s: 0.1 record { picture: false }"));
    const auto run = value_or_throw(Run::open(plan, {}));
    const MonotonicTime began(std::chrono::hours(1));
    Pacer pacer(began, scene_start);
    pacer.did(scene_start + 10ms, began + 13ms);
    Summary paced = summary_of(*run, scene_start, {}, pacer);
    EXPECT_EQ(paced["missed_deadlines"].number(), 1);
    EXPECT_EQ(paced["worst_lag_ms"].number(), 3);
    Summary virtual_time = summary_of(*run, scene_start, {}, std::nullopt);
    EXPECT_EQ(virtual_time["missed_deadlines"].number(), 0);
    EXPECT_EQ(virtual_time.find("worst_lag_ms"), nullptr);
}

TEST(Run, CountsPacketsAndAcknowledgementsWhereThereAreAny) {
    const std::string press = "duration_s: 1 source { profile { point { force_n: 5 } } } ";
    const auto in_process = whole_run(make_plan(Scene::from_text(press)));
    EXPECT_EQ(in_process->packets(), 0U);
    EXPECT_EQ(in_process->acknowledgement_bytes(), 0U);
    const auto over_udp =
        whole_run(make_plan(Scene::from_text(press + "link { udp {} encoding: PREDICTED }")));
    EXPECT_GT(over_udp->packets(), 30U) << "a heartbeat every 25 ms at least";
    EXPECT_LE(over_udp->packets(), 200U) << "one for each 5 ms";
    // An acknowledgement is a frame of some ten bytes; there is at most one for each packet.
    EXPECT_GT(over_udp->acknowledgement_bytes(), 5U);
    EXPECT_LT(over_udp->acknowledgement_bytes(), 20 * over_udp->packets());
}

TEST(Run, LeavesOutTheDecoderThatNobodyReads) {
    const Plan plan = make_plan(Scene::from_text(R"(record { force: false picture: false }
        source { profile { point { force_n: 1 } } })"));
    EXPECT_EQ(value_or_throw(Run::open(plan, {}))->hand(), nullptr);
}

}  // namespace
}  // namespace afferent
