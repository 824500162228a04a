#include "afferent/scene/scene.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// The message about a scene; "accepted" if there is none.
std::string refusal(const std::string& text) {
    try {
        Scene::from_text(text, "s.txtpb");
    } catch (const SceneError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(Scene, HasThePapersDefaults) {
    const Scene scene = Scene::from_text("");
    ASSERT_EQ(scene.patches.size(), 3U);
    EXPECT_EQ(scene.patches.at(0).name, "thumb");
    EXPECT_EQ(scene.patches.at(2).name, "middle");
    EXPECT_EQ(scene.patches.at(0).sensor.rate_hz, 200);
    EXPECT_EQ(scene.hand.emg_rate_hz, 1000);
    EXPECT_EQ(std::get<scene::SlidingWindow>(scene.decoder.kind).window_ms, 60);
    EXPECT_EQ(scene.gain.limit_n, 10);
    const Plan plan = make_plan(scene);
    EXPECT_EQ(plan.addresses, 9U);
    EXPECT_EQ(plan.elements, 9U);
    double share = 0;
    for (const PatchPlan& patch : plan.patches)
        for (const double s : patch.share) share += s;
    EXPECT_NEAR(share, 1, 1e-15);
}

TEST(Scene, NamesFileLineColumnAndFieldOfWhatItDoesNotKnow) {
    EXPECT_EQ(refusal("duration_s: 1\nhand {\n  motr {}\n}"),
              "s.txtpb:3:8: Hand has no field \"motr\": did you mean \"motor\"?");
    EXPECT_EQ(refusal("colour: 1"), "s.txtpb:1:7: Scene has no field \"colour\"");
    EXPECT_EQ(refusal("duration_s: fast"), "s.txtpb:1:13: Expected double, got: fast");
}

TEST(Scene, NamesPatchFieldRuleAndValueOfWhatIsOutOfRange) {
    EXPECT_EQ(refusal("patch {\n  name: \"thumb\"\n  neuron { tau_m_ms: -10 }\n}"),
              "s.txtpb:3:12: patch \"thumb\": neuron.tau_m_ms must be 1e-6 to 1e6, is -10");
    EXPECT_EQ(refusal("patch {\n  name: \"a\"\n  elements: 2\n  share: 0.75\n  share: 0.75\n}").substr(0, 12),
              "s.txtpb:4:3:")
        << "a list is where its first value is";
}

TEST(Scene, LooksForThePlaceInEveryPatchWhereThePatchDoesNotSayIt) {
    EXPECT_EQ(refusal("patch { name: \"a\" }\nevery_patch {\n  neuron { delta_g: -1 }\n}"),
              "s.txtpb:3:12: patch \"a\": neuron.delta_g must be 0 to 1e6, is -1");
}

TEST(Scene, MayHaveAGraspWhoseContactsAreOnTheMapOfTheBody) {
    EXPECT_EQ(
        refusal(
            "patch { name: 'a' kind: SA1 outline {} } source { grasp { point { force_n: 1 } contact {} } }"),
        "accepted");
}

// One scene for each rule, and what its message must hold.
TEST(Scene, RefusesWhatCannotBe) {
    const std::pair<std::string, const char*> cases[] = {
        {"duration_s: 0", "duration_s must be > 0"},
        {"duration_s: nan", "duration_s must be > 0"},
        {"trial { object { breaking_force_n: 7 } }",
         "trial.object.breaking_force_n must be > least_breaking_force_n, is 7"},
        {"trial { emg { centre_hz: 600 } }",
         "trial.emg.centre_hz must be > 0 and below half of emg_rate_hz, is 600"},
        {"duration_s: inf", "duration_s must be > 0"},
        {"patch { name: 'a' elements: 0 }", "elements must be 1 to 16777216, is 0"},
        {"patch { elements: 3 }", "a patch must have a name"},
        {"patch { name: 'a' } patch { name: 'a' }", "another patch has this name"},
        {"patch { name: 'a' elements: 20000000 }", "elements must be 1 to 16777216"},
        {"patch { name: 'a' elements: 10000000 } patch { name: 'b' elements: 10000000 }",
         "at most 16777216 addresses"},
        {"patch { name: 'a' share: 0.5 }", "share must be given once for each of the 3 elements"},
        {"patch { name: 'a' elements: 1 share: 1.5 }", "share[0] must be 0 to 1"},
        {"patch { name: 'a' elements: 1 share: 0.9 } patch { name: 'b' elements: 1 share: 0.9 }",
         ":1:31: all shares must add up to at most 1, add up to 1.8"},
        {"patch { name: 'a' elements_of: 'b' }", "must name an earlier patch"},
        {"patch { name: 'a' elements: 1 share: 0 }",
         "patch \"a\": neuron.tuning.force_n must be felt by elements with a share > 0, is 0"},
        {"patch { name: 'a' outline {} } source { grating { period_mm: 1 ridge_mm: 1.5 } }",
         "ridge_mm must be at most period_mm, is 1.5"},
        {"patch { name: 'a' outline {} } source { dots { spacing_mm: 1 diameter_mm: 1.5 } }",
         "diameter_mm must be at most spacing_mm, is 1.5"},
        {"patch { name: 'a' } source { grasp { point { force_n: 1 } } }",
         "contact must be given at least once, is none"},
        {"patch { name: 'a' outline {} } source { texture { longest_mm: 1 shortest_mm: 2 } }",
         "shortest_mm must be at most longest_mm, is 2"},
        {"patch { name: 'a' } patch { name: 'b' elements_of: 'a' sensor { adc_bits: 8 } }",
         "has no sensor of its own"},
        {"patch { name: 'a' field {} }", "field.weight must be given at least once"},
        {"patch { name: 'a' field { weight { element: 3 } } }",
         "field.weight.element must be below the number of"},
        {"patch { name: 'a' field { weight {} weight {} } }",
         "field.weight.element must be given once in a field"},
        {"patch { name: 'a' field { weight { weight: 0 } } }", "field[0].weight[0].weight must be > 0"},
        {"every_patch { neuron { v_th_mv: -80 } }", "v_th_mv must be > v_r_mv, is -80"},
        {"every_patch { neuron { v_r_mv: -50 } }", "v_th_mv must be > v_r_mv"},
        {"every_patch { neuron { e_k_mv: -50 } }", "e_k_mv must be < v_th_mv, is -50"},
        {"every_patch { neuron { tau_g_ms: 0 } }", "tau_g_ms must be 1e-6 to 1e6, is 0"},
        {"every_patch { neuron { tau_m_ms: nan } }", "tau_m_ms must be 1e-6 to 1e6, is nan"},
        {"every_patch { neuron { refractory_ms: -1 } }", "refractory_ms must be 0 to 1e6, is -1"},
        {"every_patch { neuron { refractory_ms: 10 } }", "below the reciprocal of the refractory period"},
        {"every_patch { neuron { tuning { begin_force_n: 30 } } }", "force_n must be > begin_force_n, is 20"},
        {"every_patch { encoder { transient {} } neuron { tuning { slope_n_per_s: 4 } } }",
         "slope_n_per_s must be > begin_slope_n_per_s, is 4"},
        {"every_patch { neuron { tuning { other_rate_hz: 50 } } }", "a rate that adaptation can reach"},
        {"every_patch { encoder { sustained { gain_mv_per_n: -1 } } }", "gain_mv_per_n must be > 0"},
        {"every_patch { encoder { sustained { bias_mv: 1 } } }", "a bias without a gain"},
        {"every_patch { encoder { transient { gain_mv_s_per_n: 1 negative_ratio: 1.1 } } }",
         "negative_ratio must be 0 to 1, is 1.1"},
        {"every_patch { encoder { vibration { gain_mv_s2_per_n: 1 threshold_n_per_s2: -1 } } }",
         "threshold_n_per_s2 must be 0 to 1e12, is -1"},
        {"every_patch { encoder { transient { threshold_n_per_s: 1 } } }",
         "threshold_n_per_s without a gain; tuning has no threshold"},
        {"every_patch { encoder { sustained { dynamic { time_ms: 0 } } } }", "time_ms must be > 0"},
        {"every_patch { encoder { sustained { slow_adaptation { part: 1 } } } }", "part must be 0.001 to"},
        {"every_patch { encoder { sustained { slow_adaptation { time_s: 0 } } } }", "time_s must be > 0"},
        {"every_patch { encoder { sustained { dynamic { corner_hz: 0 } } } }", "corner_hz must be 0.1 to"},
        {"every_patch { sensor { rate_hz: 0 } }", "rate_hz must be"},
        {"every_patch { sensor { adc_bits: 0 } }", "adc_bits must be 1 to 24"},
        {"every_patch { sensor { hysteresis: 1 } }", "hysteresis must be"},
        {"every_patch { sensor { dead_element: 3 } }", "dead_element must be below the number of elements"},
        {"every_patch { sensor { stuck_element { element: 1 force_n: 11 } } }",
         "stuck_element.force_n must be"},
        {"every_patch { sensor { calibration { counts: 1 force_n: 0 } } }", "at least two points"},
        {"every_patch { neuron { form: DENSE } } source { standard_input {} }", "form must be SPARSE here"},
        {"every_patch { sensor { rate_hz: 300 } neuron { form: DENSE } }",
         "the sampling interval is not a whole number of nanoseconds"},
        {"link { tick_us: 0.5 }", "tick_us must be 1 to 1000"},
        {"link { packet_ms: 4e-7 }", "packet_ms must be 0.001 to 1000"},
        {"link { packet_ms: 0.25 }", "packet_ms must be a multiple of tick_us"},
        {"link { heartbeat_ms: 1 }", "heartbeat_ms must be >= packet_ms"},
        {"link { prompt_ms: 2 }", "prompt_ms must be a whole part of packet_ms, is 2"},
        {"link { prompt_ms: 10 }", "prompt_ms must be a whole part of packet_ms, is 10"},
        {"link { packet_ms: 4 prompt_ms: 0.25 }", "prompt_ms must be a multiple of tick_us, is 0.25"},
        {"link { freeze_ms: 30 }", "freeze_ms must be at least twice heartbeat_ms"},
        {"link { tcp {} } source { chip { device: 'tty' } }",
         "chip must be where all neurons are fixed_point"},
        {"hand { ability_hand { port: '' } }", "hand.ability_hand.port must be"},
        {"source { hand_sensors {} }",
         "hand_sensors must be given with hand.ability_hand, whose sensors they are, is alone"},
        {"hand { ability_hand { port: '/dev/ttyUSB0' open_deg: 70 close_deg: 70 } }",
         "hand.ability_hand.open_deg must be < close_deg"},
        {"hand { ability_hand { port: '/dev/ttyUSB0' zero_counts: [1, 2] } }",
         "hand.ability_hand.zero_counts must be one for each of the 30 sensors"},
        {"link { tcp { port: 70000 } }", "tcp.port must be"},
        {"link { unix_socket { path: '' } }", "unix_socket.path must be"},
        {"link { udp { port: 70000 } }", "udp.port must be 0 to 65535"},
        {"link { serial { device: '/dev/ttyUSB0' } }",
         "serial must be on a link with keys, which afferent keys makes"},
        {"link { serial {} keys: 'keys' }", "serial.device must be the path of a tty"},
        {"link { serial { device: '/dev/ttyUSB0' baud: 300 } keys: 'keys' }", "serial.baud must be 1200 to"},
        {"link { tcp { port: 65535 } channel {} }", "tcp.port must be below 65535 where there is a channel"},
        {"link { udp { port: 65535 } channel {} }", "udp.port must be below 65535 where there is a channel"},
        {"link { unix_socket { path: '" + std::string(100, 'x') + "' } channel {} }",
         "unix_socket.path must be at most 99 characters"},
        {"link { unix_socket {} keys: 'keys' }", "keys must be on a link that can leave the machine"},
        {"link { tcp {} timing_tolerance_us: 100 }",
         "timing_tolerance_us must be 0 unless encoding is PREDICTED"},
        {"link { tcp {} encoding: PREDICTED timing_tolerance_us: 2500 }",
         "timing_tolerance_us must be >= 0 and below half of packet_ms"},
        {"link { tcp {} encoding: PREDICTED timing_tolerance_us: 0.5 }",
         "timing_tolerance_us must be a multiple of tick_us, is 0.5"},
        {"link { tcp {} encoding: PREDICTED prompt_ms: 1 }", "prompt_ms must be left out where spikes are"},
        {"every_patch { elements: 120000 } link { tcp {} encoding: PREDICTED }",
         "encoding must be RICE or FIXED_WIDTH for so many afferents"},
        {"every_patch { neuron { fixed_point {} } } source { chip { device: '/dev/ttyS0' } } "
         "link { tcp {} encoding: PREDICTED }",
         "chip must be with link.encoding RICE or FIXED_WIDTH"},
        {"every_patch { neuron { fixed_point {} } nerve {} } source { chip { device: 'tty' } } link { tcp {} "
         "}",
         "chip must be without a nerve, since its events leave as it fires, is with one"},
        {"every_patch { neuron { fixed_point {} } } source { chip { device: 'tty' } } link { tcp {} bus {} }",
         "chip must be without link.bus, since its events are past any bus, is with it"},
        {"every_patch { neuron { fixed_point {} } } source { chip { device: 'tty' } }",
         "chip must be on a link with packets, as the chip's line has, is in process"},
        {"link { named_pipes {} }", "Link has no field \"named_pipes\""},
        {"link { in_process {} channel {} }",
         "link.channel must be on a link with packets, tcp, unix_socket, udp or serial, is in process"},
        {"link { udp {} keys: '' }", "keys must be the path of a folder"},
        {"every_patch { elements: 10000 } link { udp {} packet_events: 50000 encoding: FIXED_WIDTH }",
         "packet_events must be so few that a packet takes at most 65487 bytes"},
        {"every_patch { elements: 3000 } link { udp {} }",
         "elements must be so few that the hand's samples take"},
        {"decoder { window_ms: 0 }", "window_ms must be 0.001 to 60000"},
        {"decoder { patch: 'nobody' }", "patch must be the name of a patch"},
        {"patch { name: 'p' encoder { transient {} } } decoder { patch: 'p' }",
         "patch must be a patch with a sustained encoder, unless the decoder is the filter"},
        {"patch { name: 'p' encoder { sustained { slow_adaptation {} } } } decoder { patch: 'p' }",
         "no corner frequency, dynamic term, slow adaptation, half-wave or threshold, which no decoder "
         "inverts"},
        {"patch { name: 'p' encoder { sustained { dynamic {} } } } decoder { patch: 'p' }",
         "no corner frequency, dynamic term, slow adaptation, half-wave or threshold, which no decoder "
         "inverts"},
        {"patch { name: 'p' encoder { transient { negative_ratio: 0 } } } decoder { filter {} patch: 'p' }",
         "no corner frequency, dynamic term, slow adaptation, half-wave or threshold, which no decoder "
         "inverts"},
        {"patch { name: 'p' encoder { transient { gain_mv_s_per_n: 1 threshold_n_per_s: 1 } } } "
         "decoder { filter {} patch: 'p' }",
         "no corner frequency, dynamic term, slow adaptation, half-wave or threshold, which no decoder "
         "inverts"},
        {"gain { onset_n: 10 }", "limit_n must be > onset_n"},
        {"gain { limit_n: 8 brake { contact_n: 8 } }", "gain.brake.contact_n must be < limit_n, is 8"},
        {"hand { motor { force_limit_n: 0 } }", "motor.force_limit_n must be > 0"},
        {"hand { user { effort: 2 } }", "effort must be 0 to 1"},
        {"patch { name: 'a' outline {} } source { grasp { point { force_n: 1 } contact { patch: 'b' } } }",
         "contact.patch must be the name of a patch, is \"b\""},
        {"source { profile {} }", "profile.point must be given at least once"},
        {"source { profile { point { time_s: 1 } point { time_s: 1 } } }", "increasing"},
        {"source { table {} }", "table.path must be"},
        {"runtime { threads: 1000000000 }", "threads must be 0 to 1024"},
        {"every_patch { sensor { full_scale_n: 1e308 } }", "full_scale_n must be"},
        {"decoder { exponential { time_constant_ms: 0 } }",
         "exponential.time_constant_ms must be 0.001 to 60000"},
        {"output { command_file {} }", "command_file.path must be the path of a file"},
        {"output { live_events {} } output { command_file {} }", "output[1].command_file.path must be"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string message = refusal(text);
        EXPECT_NE(message.find(expected), std::string::npos) << text << "\n  -> " << message;
        EXPECT_EQ(message.rfind("s.txtpb:", 0), 0U) << message;
    }
}

TEST(Scene, MayHaveAHeartbeatAsOftenAsPackets) {
    EXPECT_EQ(Scene::from_text("link { packet_ms: 25 heartbeat_ms: 25 }").link.heartbeat_ms, 25);
}

TEST(Scene, SaysEverythingThatIsWrongAtOnce) {
    try {
        Scene::from_text("gain { lambda_n: 0 }\nhand { motor { dead_band: 2 } }\nlink { tick_us: 0 }");
        FAIL();
    } catch (const SceneError& error) {
        EXPECT_EQ(error.messages().size(), 3U) << error.what();
    }
}

TEST(Scene, IsNotBloatedByWhatIsTooLargeOrTooDeep) {
    EXPECT_NE(refusal(std::string(2 << 20, '#')).find("at most"), std::string::npos);
    std::string deep;
    for (int i = 0; i < 10'000; ++i) deep += "patch {";
    EXPECT_NE(refusal(deep), "accepted");
}

TEST(Scene, RefusesAFileThatIsNotThere) {
    EXPECT_THROW(Scene::from_file("/nowhere/s.txtpb"), SceneError);
    EXPECT_THROW(Scene::from_file("/"), SceneError);
    try {
        Scene::from_file("six.csv");
        FAIL() << "a table is no scene";
    } catch (const SceneError& error) {
        EXPECT_STREQ(error.what(),
                     "six.csv: a table, and no scene. A scene for it: afferent inspect six.csv "
                     "--scene scene.txtpb");
    }
}

TEST(Scene, TakesWhatAPatchSaysBeforeWhatAllSay) {
    const Scene scene = Scene::from_text(R"(
        source { pushed {} }
        patch { name: "a" neuron { tau_m_ms: 5 } }
        patch { name: "b" sensor { dead_element: 1 } }
        every_patch { neuron { tau_m_ms: 20 delta_g: 0.1 } sensor { dead_element: 0 } })");
    EXPECT_EQ(scene.patches.at(0).neuron.tau_m_ms, 5);
    EXPECT_EQ(scene.patches.at(0).neuron.delta_g, 0.1);
    EXPECT_EQ(scene.patches.at(1).neuron.tau_m_ms, 20);
    EXPECT_EQ(scene.patches.at(1).sensor.dead_element, std::vector<std::uint32_t>{1})
        << "a list of its own replaces the shared one";
}

TEST(Scene, TellsOnceWhatEveryPatchSaysWrongly) {
    EXPECT_EQ(refusal("every_patch { neuron { tau_m_ms: -1 } }"),
              "s.txtpb:1:24: patch \"thumb\": neuron.tau_m_ms must be 1e-6 to 1e6, is -1");
}

TEST(Scene, SharesWhatIsLeftAmongPatchesWithoutShares) {
    const Scene scene = Scene::from_text(R"(
        patch { name: "a" elements: 2 share: [0.3, 0.1] }
        patch { name: "b" elements: 3 })");
    EXPECT_NEAR(make_plan(scene).patches.at(1).share.at(0), 0.2, 1e-15);
}

TEST(Scene, GivesANeuronOnSharedElementsAnAddressOfItsOwn) {
    const Scene scene = Scene::from_text(R"(
        patch { name: "a" elements: 2 }
        patch { name: "b" elements_of: "a" encoder { transient {} } })");
    const Plan plan = make_plan(scene);
    EXPECT_EQ(plan.addresses, 4U);
    EXPECT_EQ(plan.elements, 2U);
    EXPECT_EQ(plan.patches.at(1).first, 2U);
    EXPECT_EQ(plan.patches.at(1).reads, 0U);
}

TEST(Scene, KnowsWhetherTwoSidesMeanTheSame) {
    const std::uint64_t ours = Scene::from_text("seed: 1").fingerprint();
    EXPECT_EQ(Scene::from_text("seed: 1 name: 'other' link { tcp {} }").fingerprint(), ours)
        << "where they meet, and what it is called, does not matter";
    EXPECT_EQ(Scene::from_text("seed: 1 link { udp {} keys: 'mine' }").fingerprint(), ours);
    EXPECT_EQ(Scene::from_text("seed: 1 uncertainty { gain: 0.2 } gain { accept_unreachable_limit: true }")
                  .fingerprint(),
              ours)
        << "what the decoder takes for known is its own business";
    EXPECT_NE(Scene::from_text("seed: 2").fingerprint(), ours);
    EXPECT_NE(Scene::from_text("seed: 1 every_patch { neuron { tau_m_ms: 9 } }").fingerprint(), ours);
}

TEST(Scene, KnowsWhichPartsTwoSidesMeanDifferently) {
    const auto differ = [](const std::string& a, const std::string& b) {
        const auto ours = Scene::from_text(a).part_fingerprints();
        std::string names;
        for (const auto& [name, fingerprint] : Scene::from_text(b).part_fingerprints()) {
            const auto at = ours.find(name);
            if (at == ours.end() || at->second != fingerprint) names += name + " ";
        }
        return names;
    };
    EXPECT_EQ(differ("seed: 1", "seed: 2"), "seed ");
    EXPECT_EQ(differ("seed: 1", "seed: 1 name: 'other' link { tcp {} keys: 'mine' }"), "");
    EXPECT_EQ(differ("", "link { tcp {} packet_ms: 7 }"), "link.packet_ms ");
    EXPECT_EQ(differ("patch { name: 'a' } patch { name: 'b' elements: 2 }",
                     "patch { name: 'a' } patch { name: 'b' elements: 4 }"),
              "patch.elements ");
    EXPECT_EQ(differ("every_patch { neuron { tau_m_ms: 9 } }", "every_patch { neuron { tau_m_ms: 8 } }"),
              "patch.neuron ");
}

}  // namespace
}  // namespace afferent
