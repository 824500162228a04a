// A plan is carried out: what it says is constructed, and its bounds hold.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "afferent/nodes/run.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/nodes/stimuli.hpp"
#include "tests/nodes/whole_run.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

Scene example(const std::string& name) {
    return Scene::from_file(AFFERENT_SOURCE_DIR "/examples/" + name + ".txtpb");
}

// Every example, and scenes in which each part is there that the examples leave out, or is left out that they
// have.
std::vector<Scene> scenes() {
    std::vector<Scene> all;
    for (const char* name :
         {"grasp", "paper", "recorded", "lossy", "bus", "two_channels", "fingertip", "hand_17k"})
        all.push_back(example(name));
    for (const char* text : {
             "patch { name: 'a' neuron { delta_g: 0 } } record { force: false picture: false events: false } "
             "source { profile { point { force_n: 1 } } }",
             "record { force: false picture: false } link { tcp {} } source { link { table { path: "
             "'grip.csv' } } }",
             "link { tcp {} encoding: PREDICTED timing_tolerance_us: 500 } decoder { filter {} }",
             "link { tcp {} encoding: FIXED_WIDTH } decoder { exponential {} pooling: PER_NEURON }",
             "patch { name: 'a' elements: 6000 sensor { noise_counts: 1 } neuron { refractory_ms: 1 } } "
             "runtime { threads: 2 skip_scans_after_ms: 20 } link { udp {} channel { loss: 0.1 } "
             "packet_events: 500 }",
             "patch { name: 'a' elements: 4 field { weight { element: 0 } weight { element: 1 weight: 0.5 } "
             "} "
             "field { weight { element: 3 } } } link { in_process {} }",
             "source { pushed {} } record { force: false picture: false }",
             "every_patch { neuron { fixed_point { tick_us: 200 state_bits: 12 } } }",
             "patch { name: 'a' outline { pitch_mm: 0.5 } afferents { per_cm2: 900 } spread { gain { normal "
             "{ sd: 0.1 } } "
             "threshold { normal { sd: 0.1 } } } }",
             "patch { name: 'skin' kinds: [SA1, RA] outline {} } source { edge {} } decoder { filter {} "
             "contact {} "
             "edge {} texture {} } record { force: false picture: false }",
             "patch { name: 'skin' kind: RA outline {} } source { edge {} } decoder { sliding_window {} edge "
             "{} "
             "patch: [] } patch { name: 'other' kind: SA1 outline {} }",
             "patch { name: 'skin' kind: PC outline {} } source { indenter {} skin { wave {} } } "
             "record { force: false picture: false }",
             "patch { name: 'skin' kind: PC outline {} } source { edge {} skin { wave {} } } "
             "record { force: false picture: false }",
             "patch { name: 'a' elements: 40 spread { phase { uniform { lowest: 0 } } time_class { tau_m: "
             "0.5 } "
             "time_class {} } }",
         }) {
        all.push_back(Scene::from_text(text, text, AFFERENT_SOURCE_DIR "/examples/data"));
        if (auto* link = std::get_if<scene::LinkSource>(&all.back().source)) link->table.column = {"force_n"};
    }
    return all;
}

bool says(const Plan& plan, const std::string& part) {
    bool built = false;
    for (const PlanItem& told : plan.items) built |= told.built && told.name.find(part) != std::string::npos;
    return built;
}

// The first packets have shorter numbers.
TEST(PlanExecution, SendsAtRestWhatThePlanSays) {
    for (const char* link :
         {"tcp {}", "udp {}", "tcp {} encoding: FIXED_WIDTH",
          "tcp {} encoding: PREDICTED timing_tolerance_us: 500", "tcp {} heartbeat_ms: 20"}) {
        const Plan plan = make_plan(Scene::from_text(std::string("duration_s: 30 link { ") + link +
                                                     " } source { profile { point { force_n: 0 } } }"));
        const auto run = whole_run(plan);
        EXPECT_NEAR(static_cast<double>(run->link_bytes()), 30 * plan.resting_bytes_per_second,
                    0.3 * plan.resting_bytes_per_second)
            << link;
    }
}

TEST(PlanExecution, ConstructsWhatThePlanSaysAndNothingElse) {
    for (const Scene& scene : scenes()) {
        SCOPED_TRACE(scene.file);
        const Plan plan = make_plan(scene);
        const auto opened = value_or_throw(afferent::Run::open(plan, {}));
        const afferent::Run& run = *opened;
        const CoprocessorEnd& coprocessor = run.coprocessor();
        EXPECT_EQ(coprocessor.coprocessor().shards(), plan.shards.size());
        EXPECT_EQ(coprocessor.coprocessor().threads(), plan.threads);
        EXPECT_EQ(plan.threads > 1, says(plan, "worker threads"));
        EXPECT_EQ(coprocessor.overdue() != nullptr, says(plan, "skipping of overdue scans"));
        EXPECT_EQ(coprocessor.bus() != nullptr, says(plan, "address-event bus"));
        EXPECT_EQ(coprocessor.packetizer() != nullptr, says(plan, "packets and codec"));
        EXPECT_EQ(coprocessor.packetizer() && coprocessor.packetizer()->predictor(),
                  says(plan, "prediction of spikes"));
        EXPECT_EQ(coprocessor.source() != nullptr && !coprocessor.pushed(),
                  plan.samples_from == SamplesFrom::coprocessor);
        EXPECT_EQ(coprocessor.pushed() != nullptr, plan.samples_from == SamplesFrom::program);
        EXPECT_EQ(coprocessor.table() != nullptr || (run.hand() && run.hand()->source() && !plan.gripper),
                  says(plan, "samples between the rows"));
        EXPECT_EQ(
            std::ranges::any_of(stimuli_of(plan, Aperture(1)),
                                [](const auto& each) { return std::holds_alternative<IndenterWave>(each); }),
            says(plan, "waves in the skin"));
        EXPECT_EQ(run.channel() != nullptr, says(plan, "channel"));
        const HandEnd* hand = run.hand();
        EXPECT_EQ(hand && hand->controller(), says(plan, "decoder and gain"));
        EXPECT_EQ(hand && hand->gripper(), says(plan, "simulated motor and object"));
        EXPECT_EQ(hand && hand->source(), plan.samples_from == SamplesFrom::hand);
        EXPECT_EQ(hand != nullptr, plan.controller || plan.samples_from == SamplesFrom::hand);
        const Readouts* readouts = hand && hand->controller() ? hand->controller()->readouts() : nullptr;
        EXPECT_EQ(readouts != nullptr, says(plan, "read-out of "));
        std::size_t contacts = 0, edges = 0, textures = 0;
        for (const PlanItem& part : plan.items) {
            contacts += part.built && part.name.starts_with("read-out of contact");
            edges += part.built && part.name.starts_with("read-out of edges");
            textures += part.built && part.name.starts_with("read-out of texture");
        }
        EXPECT_EQ(readouts ? readouts->count<ContactReadout>() : 0, contacts);
        EXPECT_EQ(readouts ? readouts->count<EdgeReadout>() : 0, edges);
        EXPECT_EQ(readouts ? readouts->count<TextureReadout>() : 0, textures);
        if (hand && hand->controller()) {
            EXPECT_EQ(hand->emg().times.empty(), says(plan, "simulated user"));
        }
        for (const PatchPlan& patch : plan.patches) {
            const std::string neurons = "patch \"" + patch.name + "\": neurons, by ";
            EXPECT_EQ(patch.form == scene::Form::dense, says(plan, neurons + "a sweep")) << patch.name;
            EXPECT_EQ(patch.form == scene::Form::automatic,
                      says(plan, neurons + "prediction, and by a sweep"))
                << patch.name;
        }
        const double planned = plan.bytes_per_neuron * plan.addresses;
        const auto taken = static_cast<double>(coprocessor.coprocessor().bytes());
        EXPECT_NEAR(planned / taken, 1, 0.01) << "bytes: " << planned << " planned, " << taken << " taken";
    }
}

TEST(PlanExecution, DoesNotDecodeWhereNobodyReadsTheEstimate) {
    Scene scene;
    scene.duration_s = 0.5;
    scene.record = {.events = true, .force = false, .picture = false};
    scene.link.transport = scene::Tcp();
    scene.source =
        scene::LinkSource{{.path = AFFERENT_SOURCE_DIR "/examples/data/grip.csv", .column = {"force_n"}}};
    const Plan plan = make_plan(scene);
    int steps = 0;
    const auto run = afferent::Run::open(plan, {.step = [&](const ControllerStep&) { ++steps; }});
    ASSERT_TRUE(run);
    while (!run.value()->done()) ASSERT_TRUE(run.value()->do_next());
    run.value()->finish(plan.end());
    EXPECT_EQ(steps, 0);
    EXPECT_GT(run.value()->packets(), 0U) << "the samples have crossed the link";
}

// The hardest touch that the sensors can tell: full force and none in turn, at every sample.
std::vector<double> hardest_touch(const PatchPlan& patch, std::uint64_t sample) {
    const bool pressed = patch.sustained() || sample % 2 == 0;
    return std::vector<double>(patch.elements(), pressed ? patch.sensor.full_scale_n : 0.0);
}

TEST(PlanExecution, BoundsEventsAndBytesAtFullScale) {
    constexpr int duration_s = 1;
    int bounded = 0;
    for (const Scene& given : scenes()) {
        SCOPED_TRACE(given.file);
        Scene scene = given;
        scene.link.channel.reset();
        scene.seed = 3;
        const Plan plan = make_plan(scene);
        if (plan.addresses > 1000 || std::isinf(plan.events_per_second)) continue;
        auto pushed_scene = scene;
        pushed_scene.source = scene::Pushed();
        pushed_scene.output.clear();
        const Plan pushed = make_plan(pushed_scene);
        Observer output;
        std::uint64_t bytes = 0;
        FrameWriter writer;
        output.packet = [&](const proto::Envelope& packet) { bytes += writer.stream_frame(packet).size(); };
        const auto opened = CoprocessorEnd::open(pushed);
        ASSERT_TRUE(opened);
        CoprocessorEnd& link_end = *opened.value();
        ASSERT_NE(link_end.pushed(), nullptr);
        const TimePoint end = scene_start + std::chrono::seconds(duration_s);
        std::uint64_t sample = 0;
        for (TimePoint time = scene_start; time < end; time = sample_time(++sample, 200)) {
            for (const PatchPlan& patch : pushed.patches)
                if (patch.owns_elements) {
                    // A patch of transient afferents may read these elements as well.
                    std::vector<double> forces = hardest_touch(patch, sample);
                    if (!plan.patches.back().sustained())
                        forces.assign(forces.size(), sample % 2 ? 0 : patch.sensor.full_scale_n);
                    ASSERT_TRUE(link_end.pushed()->push({time, patch.first_element, forces}));
                }
            while (link_end.next().time < time) ASSERT_TRUE(link_end.do_next(output));
        }
        link_end.finish(end, output);
        EXPECT_LE(static_cast<double>(link_end.events()), duration_s * plan.events_per_second);
        EXPECT_GT(static_cast<double>(link_end.events()), duration_s * plan.events_per_second / 5)
            << "a bound that is never come near to says nothing";
        if (plan.packets) {
            EXPECT_GT(bytes, link_end.events() / 8) << "an event takes a bit at least";
            EXPECT_LE(static_cast<double>(bytes), duration_s * plan.bytes_per_second);
        }
        ++bounded;
    }
    EXPECT_GE(bounded, 10);
}

TEST(PlanExecution, BoundsNothingWhereSamplesComeAtAnyPace) {
    const Plan plan =
        make_plan(Scene::from_text("patch { name: 'a' encoder { transient {} } } source { table { path: 'x' "
                                   "} } link { tcp {} } decoder { patch: [] } "
                                   "record { force: false picture: false }"));
    EXPECT_TRUE(std::isinf(plan.events_per_second));
    EXPECT_TRUE(std::isinf(plan.bytes_per_second));
}

// The first scan of a touch, the first spike, and the first step that knows of it.
void expect_within_the_budget(const std::string& link, double touch_s, Duration delivery,
                              Duration packet = 4ms) {
    SCOPED_TRACE(link + ", touched at " + std::to_string(touch_s));
    const Plan plan = make_plan(Scene::from_text(
        "duration_s: 0.3 every_patch { neuron { tuning { begin_force_n: 0.01 } } } link { udp {} packet_ms: "
        "4 "
        "delivery_ms: 3 " +
        link +
        " } hand { emg_rate_hz: 500 } record { force: true } source { profile { point {} point { time_s: " +
        std::to_string(touch_s) + " } point { time_s: " + std::to_string(touch_s + 1e-6) +
        " force_n: 8 } point { time_s: 1 force_n: 8 } } }"));
    const TimePoint touch = scene_start + from_seconds(touch_s);
    std::optional<TimePoint> scan, spike, step;
    Observer output;
    output.scan = [&](const Scan& one) {
        if (!scan && one.forces_n[0] > 0) scan = one.time;
    };
    output.events = [&](std::span<const Event> events) {
        if (!spike && !events.empty()) spike = events[0].time;
    };
    output.step = [&](const ControllerStep& one) {
        if (!step && one.estimate.rate_hz > 0) step = one.time;
    };
    whole_run(plan, std::move(output));
    ASSERT_TRUE(scan && spike && step);
    const LatencyBudget& most = plan.latency;
    EXPECT_EQ(most.delivery, delivery);
    EXPECT_EQ(most.most(), 5ms + packet + delivery + 2ms);
    EXPECT_LE(*scan - touch, most.sampling + 1us);
    EXPECT_LE(*step - *spike, most.packet + most.delivery + most.step);
    EXPECT_GE(*step - *spike, 3ms) << "nothing acts before it is to be delivered";
}

// In the scene's own time, wherever a touch begins between two scans.
TEST(PlanExecution, TakesNoLongerFromTouchToCommandThanThePlanSays) {
    for (const double touch_s : {0.1, 0.1007, 0.1013, 0.1026, 0.1031, 0.1049}) {
        expect_within_the_budget("", touch_s, 3ms);
        expect_within_the_budget("prompt_ms: 1", touch_s, 3ms, 1ms);
        expect_within_the_budget("channel { latency_ms: 0.2 }", touch_s, 3ms + 200us);
        // Twice over the channel, and then as long as overtaken packets are waited for.
        expect_within_the_budget("channel { latency_ms: 7 jitter_ms: 4 reorder: 0.5 }", touch_s, 22ms + 3ms);
    }
}

TEST(PlanExecution, BoundsNoLatencyWhereNoneIsKnown) {
    const auto latency = [](const std::string& scene) {
        return make_plan(Scene::from_text("record { force: true } link { udp {} " + scene)).latency.most();
    };
    EXPECT_GT(latency("} source { profile { point { force_n: 1 } } }"), 0ns);
    EXPECT_EQ(latency("} source { pushed {} }"), 0ns) << "samples come at any pace";
    EXPECT_EQ(latency("channel { bandwidth_bps: 9600 } } source { profile { point { force_n: 1 } } }"), 0ns);
    EXPECT_EQ(latency("bus { cycle_ns: 1000000 } } source { profile { point { force_n: 1 } } }"), 0ns);
}

TEST(PlanExecution, HasNoLatencyWhereNobodyReadsTheEstimate) {
    const Plan plan =
        make_plan(Scene::from_text("record { force: false picture: false } link { tcp {} } "
                                   "source { profile { point { force_n: 1 } } }"));
    EXPECT_EQ(plan.latency.most(), 0ns);
}

TEST(PlanExecution, RunsWithMoreAddressesThanAPacketHolds) {
    const Plan plan =
        make_plan(Scene::from_text("duration_s: 0.02 every_patch { elements: 30000 } link { tcp {} } source "
                                   "{ profile { point { force_n: 1 } } }"));
    ASSERT_GT(plan.addresses, 65'535U);
    const auto run = afferent::Run::open(plan, {});
    ASSERT_TRUE(run);
    while (!run.value()->done()) ASSERT_TRUE(run.value()->do_next());
    run.value()->finish(plan.end());
    EXPECT_GT(run.value()->packets(), 0U);
}

}  // namespace
}  // namespace afferent
