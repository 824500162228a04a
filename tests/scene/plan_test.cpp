#include "afferent/scene/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace afferent {
namespace {

bool built(const Plan& plan, const std::string& name) {
    const auto part = std::find_if(plan.items.begin(), plan.items.end(),
                                   [&](const PlanItem& p) { return p.name.find(name) != std::string::npos; });
    EXPECT_NE(part, plan.items.end()) << name;
    return part != plan.items.end() && part->built;
}

TEST(Source, StatesTheGripOfAProfileAndOfAGrasp) {
    for (const char* const points :
         {"profile { point { time_s: 1 force_n: 2 } point { time_s: 3 force_n: 6 } }",
          "grasp { point { time_s: 1 force_n: 2 } point { time_s: 3 force_n: 6 } contact {} }"}) {
        const Scene scene =
            Scene::from_text("patch { name: 'a' outline {} } source { " + std::string(points) + " }");
        EXPECT_DOUBLE_EQ(stated_grip_n(scene.source, scene_start + 1500ms).value(), 3) << points;
        EXPECT_DOUBLE_EQ(stated_grip_n(scene.source, scene_start + 9s).value(), 6) << points;
    }
    EXPECT_EQ(stated_grip_n(scene::Pushed(), scene_start), std::nullopt);
}

// Whether the item of that name is built, and why.
std::string item_of(const Plan& plan, const std::string& name) {
    const auto found = std::ranges::find(plan.items, name, &PlanItem::name);
    return found == plan.items.end() ? "" : (found->built ? "built: " : "left out: ") + found->reason;
}

TEST(Plan, LeavesOutWhatASceneDoesNotNeed) {
    const Plan lean = make_plan(Scene::from_text(R"(
        patch { name: "a" neuron { delta_g: 0 } } record { force: false picture: false events: false }
        source { profile { point { force_n: 1 } } } link { in_process {} })"));
    for (const char* part : {": adaptation", "refractory", "noise", "packets", "decoder", "motor",
                             "recording of events", "picture", "worker threads"})
        EXPECT_FALSE(built(lean, part)) << part;
    for (const char* part :
         {"receptive fields", "two dimensions", "spread", "irregular intervals", "nerve", "waves"})
        EXPECT_FALSE(built(lean, part)) << part;
    EXPECT_TRUE(built(lean, "sensors"));
    EXPECT_TRUE(lean.in_process());

    const Plan full = make_plan(Scene::from_text(R"(
        patch { name: "a" elements: 20000 neuron { delta_g: 0.1 refractory_ms: 1 } sensor { noise_counts: 1 } }
        runtime { threads: 2 } link { tcp {} })"));
    for (const char* part : {": adaptation", "refractory", "noise", "packets", "decoder", "motor",
                             "recording", "picture", "worker threads"})
        EXPECT_TRUE(built(full, part)) << part;
    EXPECT_FALSE(full.in_process());
    EXPECT_EQ(full.threads, 2U);
}

// Name, whether it is built, and why; by part of the name where that begins with a patch.
TEST(Plan, SaysOfEachItemWhetherItIsBuiltAndWhy) {
    struct Expected {
        const char* name;
        const char* said;
    };
    const auto expect = [](const std::string& text, std::initializer_list<Expected> all) {
        const Plan plan = make_plan(Scene::from_text(text));
        for (const Expected& each : all) EXPECT_EQ(item_of(plan, each.name), each.said) << each.name;
    };
    expect(
        R"(patch { name: "a" elements: 2 } record { force: false picture: false events: false }
           source { profile { point { force_n: 1 } } } link { in_process {} })",
        {{"patch \"a\": sensors", "built: 2 elements"},
         {"patch \"a\": receptive fields", "left out: each afferent reads an element of its own"},
         {"patch \"a\": two dimensions", "left out: outline is not given"},
         {"patch \"a\": dynamic term", "left out: encoder.sustained.dynamic is not given"},
         {"patch \"a\": slow adaptation", "left out: encoder.sustained.slow_adaptation is not given"},
         {"patch \"a\": spread", "left out: spread is not given: afferents are alike"},
         {"patch \"a\": adaptation", "built: delta_g is 0.06"},
         {"patch \"a\": refractory period", "left out: refractory_ms is 0"},
         {"patch \"a\": irregular intervals", "left out: neuron.noise_mv is 0"},
         {"patch \"a\": nerve", "left out: nerve is not given"},
         {"patch \"a\": noise", "left out: sensor.noise_counts is 0"},
         {"address-event bus", "left out: events reach the link as they are fired"},
         {"samples between the rows of a table", "left out: the samples are no table in a file"},
         {"neurons of the emulator", "built: the scene's neurons are emulated"},
         {"packets and codec", "left out: the link is in process: events are handed over"},
         {"prompt packets", ""},
         {"keys", "left out: link.keys is not given: the link does not leave the machine"},
         {"channel", "left out: link.channel is not given: nothing is lost or delayed on purpose"},
         {"watch for silence", ""},
         {"decoder and gain", "left out: nobody reads the estimate"},
         {"decoders of parts", "left out: decoder.parts is NONE: the grip alone is estimated"},
         {"uncertainty of the sensors", "left out: nobody reads the estimate"},
         {"force of now", "left out: nobody reads the estimate"},
         {"gain by the force that comes", "left out: nobody reads the estimate"},
         {"gain by an upper bound", "left out: nobody reads the estimate"},
         {"brake at a contact", "left out: nobody reads the estimate"},
         {"closing pulse at a slip", "left out: nobody reads the estimate"},
         {"simulated motor and object", "left out: open loop: the samples come from elsewhere"},
         {"hand on a serial line", "left out: no hand.ability_hand"},
         {"simulated user", "left out: nobody reads the EMG"},
         {"recording of events", "left out: record.events"},
         {"recording of force", "left out: record.force"},
         {"picture", "left out: record.picture"},
         {"skipping of overdue scans", "left out: in real time, everything is computed, however late"},
         {"worker threads", "left out: 2 neurons are less work than waking a thread"}});
    expect(
        "patch { name: 'a' }",
        {{"decoder and gain", "built: the estimate is recorded or moves the hand"},
         {"uncertainty of the sensors", "left out: decoder is not the filter, whose sigma alone contains it"},
         {"force of now",
          "left out: sensor.delay_ms is 0 and there is no nerve: an event is of its own time"},
         {"gain by the force that comes", "left out: gain.lead_ms is 0: the gain goes by the force of now"},
         {"gain by an upper bound",
          "left out: gain.upper_bound_sigmas is 0: only that of a doubtful estimate is by its upper bound"},
         {"brake at a contact", "left out: the gain has no brake"},
         {"closing pulse at a slip", "left out: the gain has no pulse"},
         {"simulated motor and object", "built: the samples are of the simulated hand"},
         {"simulated user", "built: there is no EMG table"},
         {"recording of events", "built: record.events"},
         {"recording of force", "built: record.force"},
         {"picture", "built: record.picture"}});
    expect(
        R"(patch { name: "a" elements: 4 share: 0.5 share: 0.5 share: 0 share: 0
                   sensor { delay_ms: 20 noise_counts: 0.5 } neuron { refractory_ms: 1.5 noise_mv: 0.25 }
                   nerve { length_mm: 100 speed_m_per_s: 50 } spread { gain { normal { sd: 0.1 } } } }
           decoder { filter {} parts: PATCHES }
           gain { lead_ms: 0.5 upper_bound_sigmas: 0.5 accept_unreachable_limit: true
                  brake { command: 0.5 impulse_ms: 40 contact_n: 0.25 } pulse { pulse_ms: 30 fall_n: 0.5 } }
           runtime { skip_scans_after_ms: 12.5 }
           link { tcp {} prompt_ms: 1 channel {} bus { cycle_ns: 200 rows: 3 } stale_ms: 45 freeze_ms: 55
                  safe_ms: 165 })",
        {{"patch \"a\": spread", "built: afferents differ in gain"},
         {"patch \"a\": refractory period", "built: refractory_ms is 1.5"},
         {"patch \"a\": irregular intervals", "built: neuron.noise_mv is 0.25, of which no decoder knows"},
         {"patch \"a\": nerve", "built: each event leaves 2 ms after its spike"},
         {"patch \"a\": noise", "built: sensor.noise_counts is 0.5"},
         {"address-event bus", "built: link.bus: at most 5000000 events per second, of 3 rows"},
         {"packets and codec", "built: the link leaves the process: TCP 127.0.0.1:7450"},
         {"prompt packets", "built: link.prompt_ms: a touch begins with packets of 1 ms"},
         {"prediction of spikes", "left out: link.encoding is not PREDICTED: every event is sent"},
         {"presumption",
          "built: a span without a packet counts as silent link.delivery_ms after its end, unless one was "
          "late or lost in the last 10 s"},
         {"channel", "built: link.channel is between the two ends: afferent channel, or a run's own"},
         {"refusal of stale packets", "built: older than 47 ms when they come"},
         {"watch for silence", "built: no closing after 55 ms, safe state after 165 ms"},
         {"acknowledgement by the user",
          "left out: hand.rearm is NEW_SESSION: a new session re-arms a safe hand"},
         {"decoders of parts", "built: decoder.parts: 1 of them, beside the grip's"},
         {"uncertainty of the sensors",
          "built: uncertainty: gains within 5 % each and 1 % in common, shares within 5 % over 2 s, zeros "
          "within 0 N, hysteresis within 1 %, adaptation within 0 %"},
         {"force of now", "built: sensor.delay_ms and nerve: the force expected 22 ms later"},
         {"gain by the force that comes", "built: gain.lead_ms: the force expected in 0.5 ms"},
         {"gain by an upper bound", "built: gain.upper_bound_sigmas: of the force and 0.5 sigma"},
         {"brake at a contact", "built: gain.brake: at 0.25 N, for at most 80 ms"},
         {"closing pulse at a slip", "built: gain.pulse: for 30 ms, where the force falls by 0.5 N"},
         {"skipping of overdue scans",
          "built: runtime.skip_scans_after_ms: in real time, when 12.5 ms behind the clock"}});
    expect(
        "patch { name: 'a' nerve {} } gain { doubtful: AS_ESTIMATED } hand { rearm: BY_USER } "
        "link { udp {} keys: 'k' encoding: PREDICTED timing_tolerance_us: 300 }",
        {{"force of now", "left out: decoder is not the filter: its force is 8.181818 ms old"},
         {"presumption",
          "left out: what is not sent is foreseen from what the hand has acknowledged, and comes with the "
          "next packet"},
         {"gain by an upper bound",
          "left out: gain.doubtful is AS_ESTIMATED: the gain is that of the estimate"},
         {"keys",
          "built: link.keys: DTLS, both certificates pinned; each datagram sealed with "
          "ChaCha20-Poly1305"},
         {"prompt packets", "left out: link.prompt_ms is not given: every packet closes after packet_ms"},
         {"prediction of spikes",
          "built: link.encoding: what comes within 300 us of when both ends foresee it is not sent; what "
          "does not leaves with its packet; packets refer to what the hand has acknowledged"},
         {"acknowledgement by the user",
          "built: hand.rearm is BY_USER: a safe hand operates again when its user says so"}});
}

TEST(Plan, SweepsManyNeuronsOnOneClockThatAreNotTooStiffForIt) {
    const auto planned = [](const std::string& patch) {
        const Plan plan = make_plan(Scene::from_text(
            "duration_s: 1 source { profile { point { force_n: 1 } } } record { force: false } "
            "decoder { patch: [] } patch { name: 'skin' " +
            patch + " }"));
        return std::pair(plan.patches.front().form, plan.patches.front().form_reason);
    };
    EXPECT_EQ(planned("elements: 5000"),
              (std::pair<scene::Form, std::string>(scene::Form::automatic, "5000 neurons on one clock")));
    EXPECT_EQ(planned("elements: 5"),
              (std::pair<scene::Form, std::string>(scene::Form::sparse, "5 neurons are too few to sweep")));
    EXPECT_EQ(
        planned("elements: 5000 neuron { tau_g_ms: 0.01 delta_g: 30 }"),
        (std::pair<scene::Form, std::string>(
            scene::Form::sparse, "at this scan interval the neurons are too stiff for a sweep to pay")));
}

TEST(Plan, LeavesOutTheUserWhereTheEmgIsATable) {
    const std::string hand = "patch { name: 'a' } hand { ";
    EXPECT_EQ(item_of(make_plan(Scene::from_text(hand + "emg_table { path: 'x' } }")), "simulated user"),
              "left out: the EMG is a table");
    EXPECT_EQ(item_of(make_plan(Scene::from_text(hand + "}")), "simulated user"),
              "built: there is no EMG table");
}

TEST(Plan, SaysInWhichFormNeuronsAreComputed) {
    const auto form = [](const std::string& text, const std::string& what) {
        return item_of(make_plan(Scene::from_text("patch { name: 'a' " + text + " }")),
                       "patch \"a\": " + what);
    };
    EXPECT_TRUE(form("neuron { form: SPARSE }", "neurons, by prediction").starts_with("built: "));
    EXPECT_TRUE(form("neuron { form: DENSE }", "neurons, by a sweep per scan").starts_with("built: "));
}

TEST(Plan, TellsWhatTheLinkIs) {
    const auto plan = [](const std::string& link) {
        return make_plan(Scene::from_text("patch { name: 'a' } link { " + link + " }"));
    };
    const Plan plain = plan("udp {} channel { loss: 0.1 }");
    EXPECT_FALSE(built(plain, "keys"));
    for (const char* part : {"channel", "stale", "silence"}) EXPECT_TRUE(built(plain, part)) << part;
    const auto reason = [](const Plan& told, const std::string& name) {
        for (const PlanItem& part : told.items)
            if (part.name.find(name) != std::string::npos) return part.reason;
        return std::string();
    };
    EXPECT_NE(reason(plain, "packets").find("UDP 127.0.0.1:7450"), std::string::npos);
    EXPECT_NE(reason(plan("tcp {} keys: 'k'"), "keys").find("TLS"), std::string::npos);
    EXPECT_NE(reason(plan("serial { device: 't' } keys: 'k'"), "keys").find("ChaCha20"), std::string::npos);
    // Seals are on the line as well.
    const Plan sealed = plan("udp {} keys: 'k'");
    EXPECT_GT(sealed.resting_bytes_per_second, 2 * plain.resting_bytes_per_second);
    // Two hundred packets in a second, and a tag of 16 bytes in each.
    EXPECT_GT(sealed.bytes_per_second, plain.bytes_per_second + 200 * 16);
}

TEST(Plan, TellsWhyNoCommandIsWritten) {
    const auto reason = [](const std::string& text) {
        return item_of(make_plan(Scene::from_text(text)), std::string(scene::CommandFile::item));
    };
    EXPECT_EQ(reason(""), "left out: output is not given");
    EXPECT_EQ(reason("output { live_events { path: 's' } }"), "left out: output.command_file is not given");
}

TEST(Plan, TellsWhoGivesTheEmg) {
    const auto user = [](const std::string& text) {
        return item_of(make_plan(Scene::from_text(text)), "simulated user");
    };
    EXPECT_EQ(user(""), "built: there is no EMG table");
    EXPECT_EQ(user("record { force: false picture: false } source { profile { point { force_n: 1 } } }"),
              "left out: nobody reads the EMG");
}

TEST(Plan, TellsOfTheDecodersOfParts) {
    const auto parts = [](const std::string& text) {
        return item_of(make_plan(Scene::from_text("patch { name: 'a' elements: 2 } " + text)),
                       "decoders of parts");
    };
    EXPECT_EQ(parts(""), "left out: decoder.parts is NONE: the grip alone is estimated");
    EXPECT_EQ(parts("decoder { parts: ELEMENTS }"), "built: decoder.parts: 2 of them, beside the grip's");
}

TEST(Plan, HasAShardForEach1024AfferentsOfAPatch) {
    const auto shards = [](int elements) {
        return make_plan(Scene::from_text("patch { name: 'a' elements: " + std::to_string(elements) + " }"))
            .shards.size();
    };
    EXPECT_EQ(shards(1024), 1U);
    EXPECT_EQ(shards(1025), 2U);
}

TEST(Plan, AddsUpTheDelaysOfTheChain) {
    const LatencyBudget latency{
        .sampling = 1ms, .sensor = 2ms, .nerve = 4ms, .packet = 8ms, .delivery = 16ms, .step = 32ms};
    EXPECT_EQ(latency.most(), 63ms);
    const auto delivery = [](const std::string& link) {
        return make_plan(Scene::from_text("patch { name: 'a' } link { delivery_ms: 5 " + link + " }"),
                         Commands::wanted)
            .latency.delivery;
    };
    EXPECT_EQ(delivery("tcp {} channel { latency_ms: 40 jitter_ms: 7 }"), 47ms);
    EXPECT_EQ(delivery("tcp {} channel { latency_ms: 40 jitter_ms: 7 reorder: 0.1 }"), 94ms);
    EXPECT_EQ(delivery("udp {} channel { latency_ms: 40 jitter_ms: 7 }"), 52ms) << "others are waited for";
}

TEST(Plan, TellsOfWavesInTheSkin) {
    const auto waves = [](const std::string& source) {
        return item_of(make_plan(Scene::from_text(
                           "record { force: false picture: false } patch { name: 'a' kind: PC outline {} } "
                           "source { " +
                           source + " }")),
                       "waves in the skin");
    };
    EXPECT_EQ(waves("indenter {}"), "left out: source.skin.wave is not given");
    EXPECT_EQ(waves("edge {} skin { wave {} }"), "left out: no indenter sends any");
    EXPECT_TRUE(waves("indenter {} skin { wave {} }").starts_with("built: source.skin.wave: all elements"));
}

TEST(Plan, TellsOfPromptPackets) {
    const auto plan = [](const std::string& link) {
        return make_plan(Scene::from_text("link { tcp {} " + link + " }"));
    };
    EXPECT_EQ(item_of(plan(""), "prompt packets"),
              "left out: link.prompt_ms is not given: every packet closes after packet_ms");
    const Plan prompt = plan("prompt_ms: 1");
    EXPECT_EQ(item_of(prompt, "prompt packets"),
              "built: link.prompt_ms: a touch begins with packets of 1 ms");
    ASSERT_TRUE(prompt.packets);
    EXPECT_EQ(prompt.packets->span, 1ms);
    EXPECT_EQ(prompt.packets->gathered_spans, 5U);
    EXPECT_EQ(prompt.latency.packet, 1ms);
    EXPECT_EQ(plan("").latency.packet, 5ms);
}

// A sensor whose calibration goes beyond its full scale feels more, and makes more events.
TEST(Plan, BoundsEventsByTheHighestForceOfACalibration) {
    const auto events = [](const std::string& sensor) {
        return make_plan(Scene::from_text("every_patch { sensor { " + sensor + " } neuron { delta_g: 0 } }"))
            .events_per_second;
    };
    const double usual = events("");
    EXPECT_EQ(events("calibration { counts: 0 } calibration { counts: 4095 force_n: 10 }"), usual);
    EXPECT_GT(events("calibration { counts: 0 } calibration { counts: 4095 force_n: 20 }"), 1.5 * usual);
}

// From one sample to the next, 5 ms later, an element's 10 N may come: 2,000 N/s, which this afferent feels
// twice.
TEST(Plan, SaysWhereNoForceIsBeyondAThreshold) {
    const auto plan = [](const std::string& threshold_n_per_s) {
        return make_plan(Scene::from_text(
            "patch { name: 'a' sensor { full_scale_n: 10 rate_hz: 200 } } patch { name: 'b' elements_of: 'a' "
            "field { weight { element: 0 weight: 2 } } encoder { transient { gain_mv_s_per_n: 1 "
            "threshold_n_per_s: " +
            threshold_n_per_s + " } } }"));
    };
    const std::string spikes = "patch \"b\": spikes";
    const Plan near = plan("3900");
    EXPECT_EQ(item_of(near, spikes), "");
    const Plan beyond = plan("4000");
    EXPECT_EQ(item_of(beyond, spikes),
              "left out: no sample of its sensors drives a neuron beyond its threshold");
    EXPECT_GT(near.events_per_second, beyond.events_per_second);
    EXPECT_GT(beyond.events_per_second, 0) << "those of the patch beside it";
    EXPECT_EQ(item_of(near, "patch \"b\": transient encoder"),
              "built: drive in proportion to its rate of change, above 3900 N/s");
}

// Each afferent is a group of its own; comparing each with all others would take half a minute.
TEST(Plan, DecodesAHundredThousandElementsThatDiffer) {
    constexpr std::uint32_t elements = 100'000;
    Scene scene;
    scene.patches = {{.name = "skin", .elements = elements}};
    for (std::uint32_t i = 0; i < elements; ++i)
        scene.patches[0].share.push_back((1 + 0.5 * i / elements) * 0.7 / elements);
    scene.decoder.kind = scene::Filter();
    const Plan plan = make_plan(scene, Commands::wanted);
    EXPECT_EQ(plan.controller.value().afferents.groups.size(), elements);
    EXPECT_EQ(plan.controller.value().afferents.afferents.size(), elements);
}

// Of a pitch of 1 mm: the hypotenuse of 0.5 and the aperture's 0.5966 mm.
TEST(Plan, SaysWhereAGridAllowsForNoFieldAsNarrowAsAsked) {
    const auto fields = [](const std::string& sd_mm) {
        return item_of(make_plan(Scene::from_text(
                           "patch { name: 'a' outline { rectangle { width_mm: 4 height_mm: 4 } } "
                           "afferents { place {} field_sd_mm: " +
                           sd_mm + " } } source { edge {} } record { force: false picture: false }")),
                       "patch \"a\": two dimensions");
    };
    const std::string grid = "built: elements in a grid of 1 mm, 1 afferents at places of their own";
    EXPECT_EQ(fields("0.78"), grid);
    EXPECT_EQ(fields("0.5"),
              grid + ", whose fields are 0.778416 mm in place of 0.5: a pitch of 1 mm allows for no less");
}

TEST(Plan, TellsWhichBoundTheGainGoesBy) {
    const auto gain = [](const std::string& text) {
        return item_of(make_plan(Scene::from_text("gain { " + text + " }"), Commands::wanted),
                       "gain by an upper bound");
    };
    EXPECT_EQ(gain("upper_bound_sigmas: 0.5"), "built: gain.upper_bound_sigmas: of the force and 0.5 sigma");
    EXPECT_EQ(gain("upper_bound_sigmas: 0 doubtful: AS_ESTIMATED"),
              "left out: gain.doubtful is AS_ESTIMATED: the gain is that of the estimate");
    EXPECT_EQ(
        gain("upper_bound_sigmas: 0"),
        "left out: gain.upper_bound_sigmas is 0: only that of a doubtful estimate is by its upper bound");
}

TEST(Plan, HasNoGainWhereNobodyReadsTheEstimate) {
    const Plan plan =
        make_plan(Scene::from_text("source { pushed {} } record { force: false picture: false } "
                                   "gain { upper_bound_sigmas: 0.5 }"));
    ASSERT_FALSE(plan.controller);
    EXPECT_EQ(item_of(plan, "gain by an upper bound"), "left out: nobody reads the estimate");
}

TEST(Plan, HasABrakeWhereTheGainHasOneByTheMotorOfTheHand) {
    const std::string motor = " hand { motor { time_constant_ms: 40 force_limit_n: 26.5 dead_band: 0.08 } }";
    const Plan with =
        make_plan(Scene::from_text("gain { brake { command: 0.5 impulse_ms: 20 contact_n: 0.4 release_n: 0.2 "
                                   "release_ms: 90 } }" +
                                   motor),
                  Commands::wanted);
    EXPECT_EQ(with.controller.value().reflexes.brake, (ContactReflex::Parameters{.command = 0.5,
                                                                                 .impulse = 20ms,
                                                                                 .contact_n = 0.4,
                                                                                 .release_n = 0.2,
                                                                                 .release = 90ms,
                                                                                 .time_constant = 40ms,
                                                                                 .force_limit_n = 26.5,
                                                                                 .dead_band = 0.08}));
    const std::string name = "brake at a contact";
    EXPECT_EQ(item_of(with, name), "built: gain.brake: at 0.4 N, for at most 40 ms");
    const Plan without = make_plan(Scene::from_text(motor), Commands::wanted);
    EXPECT_EQ(without.controller.value().reflexes, Reflexes::Parameters());
    EXPECT_EQ(item_of(without, name), "left out: the gain has no brake");
    const Plan unread = make_plan(
        Scene::from_text("source { pushed {} } record { force: false picture: false } gain { brake {} }"));
    EXPECT_EQ(item_of(unread, name), "left out: nobody reads the estimate");
    EXPECT_THROW(Scene::from_text("gain { brake { contact_n: 0.2 release_n: 0.2 } }").check(), SceneError);
}

TEST(Plan, HasAPulseWhereTheGainHasOneBesideTheFilter) {
    const std::string motor = " hand { motor { dead_band: 0.07 } }";
    const Plan with = make_plan(
        Scene::from_text("decoder { filter {} } gain { pulse { command: 0.5 pulse_ms: 70 fall_n: 0.2 "
                         "fall_sigmas: 2 within_ms: 90 settle_ms: 300 most: 4 } }" +
                         motor),
        Commands::wanted);
    EXPECT_EQ(with.controller.value().reflexes.pulse, (SlipPulse::Parameters{.command = 0.5,
                                                                             .pulse = 70ms,
                                                                             .fall_n = 0.2,
                                                                             .fall_sigmas = 2,
                                                                             .within = 90ms,
                                                                             .settle = 300ms,
                                                                             .most = 4,
                                                                             .dead_band = 0.07}));
    const std::string name = "closing pulse at a slip";
    EXPECT_EQ(item_of(with, name), "built: gain.pulse: for 70 ms, where the force falls by 0.2 N");
    const Plan without = make_plan(Scene::from_text("decoder { filter {} }"), Commands::wanted);
    EXPECT_EQ(item_of(without, name), "left out: the gain has no pulse");
    for (const char* other : {"sliding_window {}", "exponential {}", "interval {}", "inversion {}"}) try {
            make_plan(Scene::from_text("decoder { " + std::string(other) + " } gain { pulse {} }"),
                      Commands::wanted);
            ADD_FAILURE() << other << ": its estimate falls while the force holds";
        } catch (const SceneError& error) {
            EXPECT_NE(
                std::string(error.what()).find("gain.pulse must be absent unless the decoder is the filter"),
                std::string::npos)
                << error.what();
        }
}

TEST(Plan, SaysWhatASustainedEncoderHasBesides) {
    const auto of = [](const std::string& encoder, const std::string& item) {
        const Plan plan =
            make_plan(Scene::from_text("patch { name: 'a' " + encoder +
                                       " } source { pushed {} } record { force: false picture: false }"));
        return item_of(plan, "patch \"a\": " + item);
    };
    const std::string both = "encoder { sustained { dynamic {} slow_adaptation {} } }";
    EXPECT_EQ(of(both, "dynamic term"), "built: encoder.sustained.dynamic: a rise of the force drives, too");
    EXPECT_EQ(of(both, "slow adaptation"),
              "built: encoder.sustained.slow_adaptation: a held force drives less and less");
    EXPECT_EQ(of("outline {} kind: SA1_DYNAMIC", "dynamic term"),
              "built: encoder.sustained.dynamic: a rise of the force drives, too");
    EXPECT_EQ(of("outline {} kind: RA", "slow adaptation"), "") << "there is nothing to leave out";
}

TEST(Plan, SaysWhichHalfWavesDrive) {
    const auto of = [](const std::string& transient) {
        const Plan plan = make_plan(
            Scene::from_text("patch { name: 'a' encoder { transient { gain_mv_s_per_n: 1 " + transient +
                             " } } } source { pushed {} } record { force: false picture: false }"));
        const auto item = std::find_if(plan.items.begin(), plan.items.end(), [](const PlanItem& each) {
            return each.reason.find("its rate of change") != std::string::npos;
        });
        return item == plan.items.end() ? std::string() : item->reason;
    };
    EXPECT_EQ(of("").find("half-wave"), std::string::npos);
    EXPECT_NE(of("negative_ratio: 0").find("its rate of change, its positive half-wave"), std::string::npos)
        << of("negative_ratio: 0");
    EXPECT_NE(of("negative_ratio: 0.5").find("its rate of change, its negative half-wave 0.5 times"),
              std::string::npos);
    EXPECT_NE(of("threshold_n_per_s: 2").find("its rate of change, above 2 N/s"), std::string::npos);
}

// Events of one age are decoded together; where nobody decodes, nerves may differ.
TEST(Plan, RefusesNervesOfSeveralDelaysForOneDecoder) {
    const std::string patches =
        "link { tcp {} } patch { name: 'a' } patch { name: 'b' nerve {} } patch { name: 'c' nerve { "
        "length_mm: "
        "450 } } ";
    const auto refusal = [&](const std::string& decoder) {
        try {
            make_plan(Scene::from_text(patches + decoder), Commands::wanted);
        } catch (const SceneError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    const std::string all = refusal("");
    EXPECT_NE(
        all.find("decoder.patch must be patches whose nerves delay events by the same time, is \"a\" and "
                 "\"b\""),
        std::string::npos)
        << all;
    EXPECT_EQ(refusal("decoder { patch: ['b', 'c'] }"), "");
    EXPECT_NO_THROW(make_plan(Scene::from_text(
        patches + "source { profile { point {} } } record { force: false picture: false }")));
}

TEST(Plan, TellsTheFilterHowOldItsSamplesAre) {
    const auto plan = [](const std::string& decoder, const std::string& delay) {
        return make_plan(Scene::from_text("link { tcp {} } decoder { " + decoder + " } patch { name: 'a' } " +
                                          "patch { name: 'b' sensor { " + delay + " } }"),
                         Commands::wanted);
    };
    const std::string name = "force of now";
    const Plan late = plan("filter {}", "delay_ms: 45");
    EXPECT_EQ(item_of(late, name), "built: sensor.delay_ms and nerve: the force expected 45 ms later");
    EXPECT_EQ(late.controller.value().afferents.delay, 45ms);
    EXPECT_EQ(plan("filter {} patch: 'a'", "delay_ms: 45").controller.value().afferents.delay, 0ms)
        << "the late patch is not read";
    EXPECT_EQ(late.latency.sensor, 45ms);
    EXPECT_EQ(late.latency.most(), plan("filter {}", "").latency.most() + 45ms);
    const Plan far = plan("filter { } patch: 'b'", "delay_ms: 45 } nerve { length_mm: 600 speed_m_per_s: 60");
    EXPECT_EQ(far.controller.value().afferents.delay, 55ms);
    EXPECT_EQ(item_of(far, "patch \"b\": nerve"), "built: each event leaves 10 ms after its spike");
    EXPECT_EQ(item_of(far, "patch \"a\": nerve"), "left out: nerve is not given");
    EXPECT_EQ(far.latency.nerve, 10ms);
    EXPECT_EQ(far.latency.most(), late.latency.most() + 10ms);
    EXPECT_EQ(item_of(plan("inversion {}", "delay_ms: 45"), name),
              "left out: decoder is not the filter: its force is 45 ms old");
    EXPECT_EQ(item_of(plan("filter {}", ""), name),
              "left out: sensor.delay_ms is 0 and there is no nerve: an event is of its own time");
    try {
        Scene::from_text(
            "patch { name: 'skin' kind: SA1 outline {} sensor { delay_ms: 5 } } source { edge {} }")
            .check();
        ADD_FAILURE() << "stimuli press when they press";
    } catch (const SceneError& error) {
        EXPECT_NE(std::string(error.what()).find("delay_ms must be 0 beside stimuli on the skin"),
                  std::string::npos)
            << error.what();
    }
}

TEST(Plan, LooksAheadByTheLeadOfTheGain) {
    const std::string name = "gain by the force that comes";
    const Plan with =
        make_plan(Scene::from_text("decoder { filter {} } gain { lead_ms: 60 }"), Commands::wanted);
    EXPECT_EQ(std::get<FilterParameters>(with.controller.value().decoder).lead, 60ms);
    EXPECT_EQ(item_of(with, name), "built: gain.lead_ms: the force expected in 60 ms");
    const Plan without = make_plan(Scene::from_text("decoder { filter {} }"), Commands::wanted);
    EXPECT_EQ(std::get<FilterParameters>(without.controller.value().decoder).lead, 0ms);
    EXPECT_EQ(item_of(without, name), "left out: gain.lead_ms is 0: the gain goes by the force of now");
    try {
        make_plan(Scene::from_text("gain { lead_ms: 60 }"), Commands::wanted);
        FAIL() << "the window knows no speed";
    } catch (const SceneError& error) {
        EXPECT_NE(std::string(error.what()).find("gain.lead_ms must be 0 unless the decoder is the filter"),
                  std::string::npos)
            << error.what();
    }
}

TEST(Plan, TellsTheDecoderHowWellItsSensorsAreKnown) {
    const Plan plan = make_plan(Scene::from_text(
        "decoder { filter {} parts: PATCHES } uncertainty { gain: 0.08 share: 0.25 share_time_s: 3 }"));
    const Uncertainty told{.gain = 0.08, .share = 0.25, .share_time_s = 3};
    EXPECT_EQ(plan.controller.value().afferents.uncertainty, told);
    ASSERT_EQ(plan.controller.value().parts.size(), 3U);
    for (const PartPlan& part : plan.controller.value().parts)
        EXPECT_EQ(part.decoded.afferents.uncertainty, told);
    EXPECT_EQ(
        item_of(plan, "uncertainty of the sensors"),
        "built: uncertainty: gains within 8 % each and 1 % in common, shares within 25 % over 3 s, zeros "
        "within 0 N, "
        "hysteresis within 1 %, adaptation within 0 %");
    EXPECT_FALSE(built(make_plan(Scene()), "uncertainty of the sensors")) << "a window has no use for it";
}

TEST(Plan, StartsNoThreadForNineElements) {
    const Plan plan = make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb"));
    EXPECT_EQ(plan.threads, 1U);
    EXPECT_FALSE(built(plan, "worker threads"));
}

TEST(Plan, CostsLessWithoutAdaptation) {
    const double with = make_plan(Scene::from_text("patch { name: 'a' elements: 1000 }")).bytes_per_neuron;
    const double without =
        make_plan(Scene::from_text("patch { name: 'a' elements: 1000 neuron { delta_g: 0 } }"))
            .bytes_per_neuron;
    EXPECT_LT(without, with);
}

TEST(Plan, TellsTheFileOfALinkThatIsOne) {
    EXPECT_EQ(link_file(Scene::from_text("link { file { path: \"/tmp/a.events\" } }")), "/tmp/a.events");
    EXPECT_EQ(link_file(Scene::from_text("link { tcp {} }")), std::nullopt);
}

TEST(Plan, TellsWhatGivesAPatchTwoDimensions) {
    const auto reason = [](const std::string& patch) {
        const Plan plan =
            make_plan(Scene::from_text("source { pushed {} } patch { name: \"a\" " + patch + " }"));
        for (const PlanItem& item : plan.items)
            if (item.reason.find(" mm") != std::string::npos ||
                item.reason.find("places") != std::string::npos || item.reason == "outline is not given")
                return item.reason;
        return std::string();
    };
    EXPECT_EQ(reason("elements: 2"), "outline is not given");
    EXPECT_EQ(reason("outline { rectangle { width_mm: 4 height_mm: 4 } pitch_mm: 1 }"),
              "elements in a grid of 1 mm");
    EXPECT_EQ(reason("outline { rectangle { width_mm: 4 height_mm: 4 } pitch_mm: 1 } "
                     "afferents { place { x_mm: 0 y_mm: 0 } place { x_mm: 1 y_mm: 0 } }"),
              "elements in a grid of 1 mm, 2 afferents at places of their own");
}

}  // namespace
}  // namespace afferent
