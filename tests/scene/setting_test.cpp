#include <gtest/gtest.h>

#include "afferent/scene/scene.hpp"

namespace afferent {
namespace {

Scene set(const std::string& text, std::initializer_list<const char*> settings) {
    std::vector<Setting> all;
    for (const char* each : settings) all.push_back(Setting::from(each));
    return Scene::from_text(text, "scene.txtpb", ".", all);
}

std::string refusal(const std::string& text, const char* setting) {
    try {
        set(text, {setting});
    } catch (const SceneError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(Setting, OfAPatchGoesToEveryPatch) {
    for (const Scene& scene :
         {set("source { pushed {} }", {"neuron.delta_g=0.25"}),
          set("source { pushed {} } patch { name: 'a' neuron { delta_g: 1 } } patch { name: 'b' }",
              {"patch.neuron.delta_g=0.25"}),
          set("source { pushed {} } every_patch { neuron { delta_g: 1 } }", {"neuron.delta_g=0.25"})}) {
        ASSERT_GE(scene.patches.size(), 2u);
        for (const scene::Patch& patch : scene.patches) EXPECT_EQ(patch.neuron.delta_g, 0.25) << patch.name;
    }
}

// A patch that reads the elements of another has afferents of its own and no sensor.
TEST(Setting, OfASensorGoesToThePatchThatHasIt) {
    const Scene scene =
        set("source { pushed {} } patch { name: 'a' } patch { name: 'b' elements_of: 'a' "
            "encoder { transient {} } }",
            {"neuron.delta_g=0.25", "sensor.rate_hz=100"});
    ASSERT_EQ(scene.patches.size(), 2u);
    for (const scene::Patch& patch : scene.patches) EXPECT_EQ(patch.neuron.delta_g, 0.25) << patch.name;
    EXPECT_EQ(scene.patches[0].sensor.rate_hz, 100);
}

TEST(Setting, ReachesAPatchByNameAndByPlace) {
    const Scene scene = set("", {"patch[index].sensor.rate_hz=100", "patch[2].sensor.rate_hz=50"});
    EXPECT_EQ(scene.patches.at(0).sensor.rate_hz, 200);
    EXPECT_EQ(scene.patches.at(1).sensor.rate_hz, 100);
    EXPECT_EQ(scene.patches.at(2).sensor.rate_hz, 50);
    EXPECT_EQ(set("patch { name: 'left.3' }", {"patch[left.3].elements=5"}).patches.at(0).elements, 5u);
}

TEST(Setting, NamesAnAlternative) {
    const std::string text = "decoder { sliding_window { window_ms: 30 } pooling: PER_NEURON }";
    const Scene other = set(text, {"decoder=filter"});
    EXPECT_TRUE(std::holds_alternative<scene::Filter>(other.decoder.kind));
    EXPECT_EQ(other.decoder.pooling, Pooling::per_neuron);
    // The one that is there keeps its fields.
    const Scene same = set(text, {"decoder=sliding_window"});
    EXPECT_EQ(std::get<scene::SlidingWindow>(same.decoder.kind).window_ms, 30);
    EXPECT_EQ(refusal(text, "decoder=filte"),
              "decoder=filte: must be sliding_window, exponential, interval, inversion or filter, is filte");
}

TEST(Setting, TakesListsMessagesAndNothing) {
    EXPECT_EQ(set("source { pushed {} } patch { name: 'a' share: [0.4, 0.3, 0.3] }",
                  {"patch.share=[0.5, 0.3, 0.2]"})
                  .patches[0]
                  .share,
              (std::vector{0.5, 0.3, 0.2}));
    const Scene lossy = set("link { udp {} channel { latency_ms: 3 } }", {"link.channel={loss: 0.1}"});
    EXPECT_EQ(lossy.link.channel.value().loss, 0.1);
    EXPECT_EQ(lossy.link.channel.value().latency_ms, 0);  // a message is given whole
    EXPECT_FALSE(set("link { udp {} channel { latency_ms: 3 } }", {"link.channel="}).link.channel);
    for (const char* quoted_or_not : {"decoder.patch=thumb", "decoder.patch=\"thumb\""})
        EXPECT_EQ(set("source { pushed {} }", {quoted_or_not}).decoder.patch,
                  std::vector<std::string>{"thumb"});
    EXPECT_EQ(set("", {"link.unix_socket.path=a b\"c.sock"}).link.transport,
              scene::Transport(scene::UnixSocket{.path = "a b\"c.sock"}));
}

TEST(Setting, LaterOnesReplaceEarlierOnes) { EXPECT_EQ(set("seed: 1", {"seed=2", "seed=3"}).seed, 3u); }

TEST(Setting, LeavesTheSensorToThePatchThatHasTheElements) {
    const Scene scene =
        set("patch { name: 'a' } patch { name: 'b' elements_of: 'a' }", {"sensor.rate_hz=100"});
    EXPECT_EQ(scene.patches.at(0).sensor.rate_hz, 100);
}

TEST(Setting, IsNamedByWhatItMakesWrong) {
    EXPECT_EQ(refusal("patch { name: 'a' }", "neuron.tau_m_ms=-10"),
              "neuron.tau_m_ms=-10: patch \"a\": neuron.tau_m_ms must be 1e-6 to 1e6, is -10");
    EXPECT_EQ(refusal("", "neuron.delta_gg=1"),
              "neuron.delta_gg=1: Neuron has no field \"delta_gg\": did you mean \"delta_g\"?");
    EXPECT_EQ(refusal("", "patch[thump].elements=1"), "patch[thump].elements=1: there is no patch \"thump\"");
    EXPECT_EQ(refusal("", "seed=1 name: 'x'"), "seed=1 name: 'x': must be one value, is 1 name: 'x'");
    EXPECT_EQ(refusal("", "gain={limit_n: 9 foo: 3}"), "gain={limit_n: 9 foo: 3}: Gain has no field \"foo\"");
    EXPECT_EQ(refusal("", "decoder.parts=PATCH"),
              "decoder.parts=PATCH: must be NONE, PATCHES or ELEMENTS, is PATCH");
    EXPECT_EQ(refusal("", "gain[0].onset_n=1"),
              "gain[0].onset_n=1: gain is not a list of parts: give it whole");
    EXPECT_EQ(refusal("", "patch[0.elements=1"), "patch[0.elements=1: a bracket is not closed");
    EXPECT_EQ(refusal("", "duration_s.x=1"), "duration_s.x=1: duration_s has no fields");
    for (const char* text : {"seed", "=1"})
        EXPECT_NE(refusal("", text).find("is no setting"), std::string::npos) << text;
    EXPECT_EQ(refusal("patch { name: 'a' outline {} }", "source.skin.modulus_kpa=1"),
              "source.skin.modulus_kpa=1: source has no stimulus: an edge, indenter, grating, dots, texture "
              "or grasp")
        << "a part of what is wrong";
    EXPECT_EQ(Setting::from("a=1").path, "a");
    EXPECT_NE(refusal("patch { name: 'a' }", "patch[0]={name: 'b'").find("must be a message in braces"),
              std::string::npos);
    // What it leaves alone keeps its place in the text.
    EXPECT_EQ(refusal("\nlink { packet_ms: 9 heartbeat_ms: 3 }", "seed=1").substr(0, 14), "scene.txtpb:2:");
}

TEST(Setting, ChangesASceneBuiltInCode) {
    Scene scene;
    scene.patches = {{.name = "thumb", .elements = 2}};
    const std::vector<Setting> settings{{"neuron.delta_g", "0.5"}, {"decoder", "inversion"}};
    const Scene changed = scene.with(settings);
    Scene expected = scene;
    expected.patches[0].neuron.delta_g = 0.5;
    expected.decoder.kind = scene::Inversion();
    EXPECT_EQ(changed.text(), expected.text());
    const std::vector<Setting> wrong{{"patch[0].elements", "0"}};
    EXPECT_THROW(scene.with(wrong), SceneError);
}

}  // namespace
}  // namespace afferent
