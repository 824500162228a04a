// Which patches have which read-outs, and what these are told of receptive fields.
#include <gtest/gtest.h>

#include <cmath>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/hand/aperture.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

ControllerPlan controller_of(const std::string& text) {
    return make_plan(Scene::from_text(text), Commands::wanted).controller.value();
}

std::string why_not(const std::string& text) {
    try {
        (void)make_plan(Scene::from_text(text), Commands::wanted);
    } catch (const SceneError& error) {
        return error.what();
    }
    return "";
}

TEST(ReadoutPlans, AreLeftOutUnlessTheSceneAsks) {
    const std::string skin = "patch { name: 'skin' kind: SA1 outline {} } source { edge {} } ";
    EXPECT_TRUE(controller_of(skin).readouts.parameters.empty());
    const auto contact = controller_of(skin + "decoder { filter {} contact {} }").readouts.parameters;
    ASSERT_EQ(contact.size(), 1U);
    EXPECT_TRUE(std::holds_alternative<ContactReadout::Parameters>(contact[0]));
    const auto texture = controller_of(skin + "decoder { texture {} }").readouts.parameters;
    ASSERT_EQ(texture.size(), 1U);
    EXPECT_TRUE(std::holds_alternative<TextureReadout::Parameters>(texture[0]));
    const auto edge = controller_of(skin + "decoder { edge {} }").readouts.parameters;
    ASSERT_EQ(edge.size(), 1U);
    EXPECT_TRUE(std::holds_alternative<EdgeReadout::Parameters>(edge[0]));
    EXPECT_TRUE(Controller(Scene::from_text(skin + "decoder { edge {} }")).readouts());
    EXPECT_FALSE(Controller(Scene::from_text(skin)).readouts());
    // Nobody else reads the estimate.
    const std::string unread = skin + "record { force: false picture: false } ";
    EXPECT_FALSE(make_plan(Scene::from_text(unread)).controller);
    EXPECT_TRUE(make_plan(Scene::from_text(unread + "decoder { edge {} }")).controller);
}

TEST(ReadoutPlans, AreWrittenAsTheyAreRead) {
    const Scene scene = Scene::from_text(
        "patch { name: 'skin' kind: SA1 outline {} } source { edge {} } decoder { filter {} contact { "
        "interval_ms: 20 } "
        "edge {} }");
    EXPECT_NE(scene.text().find("contact { interval_ms: 20 } edge { }"), std::string::npos) << scene.text();
    EXPECT_EQ(Scene::from_text(scene.text()).decoder, scene.decoder);
}

TEST(ReadoutPlans, SayWhatAPatchCannotHave) {
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'tip' kinds: [SA1, RA, PC] outline {} } patch { name: 'plain' } patch { name: 'few' "
        "outline { rectangle { width_mm: 2 height_mm: 1 } } } patch { name: 'eight' outline { rectangle { "
        "width_mm: 4 height_mm: 2 } } } patch { name: 'slope' elements_of: 'tip SA1' "
        "encoder "
        "{ transient { gain_mv_s_per_n: 300 } } } patch { name: 'many' outline { rectangle { width_mm: 40 "
        "height_mm: 40 } } sensor { full_scale_n: 1e5 } } "
        "source { pushed {} } decoder { filter {} contact {} edge {} texture {} }"));
    const auto reason = [&](const std::string& name) {
        for (const PlanItem& part : plan.items)
            if (part.name == "read-out of " + name) return (part.built ? "built: " : "") + part.reason;
        return std::string("none");
    };
    EXPECT_NE(reason("texture, \"tip SA1\"").find("decoder.texture: waves over "), std::string::npos)
        << reason("texture, \"tip SA1\"");
    EXPECT_TRUE(reason("texture, \"tip RA\"").starts_with("built"));
    EXPECT_NE(reason("texture, \"tip PC\"").find("fields are as wide as the skin"), std::string::npos);
    EXPECT_NE(reason("texture, \"plain\"").find("no positions"), std::string::npos);
    EXPECT_NE(reason("texture, \"few\"").find("too few: 2 afferents, at least 24"), std::string::npos);
    EXPECT_NE(reason("texture, \"many\"").find("too many: 1600 afferents, at most 256"), std::string::npos);
    EXPECT_TRUE(reason("contact, \"tip SA1\"").starts_with("built")) << reason("contact, \"tip SA1\"");
    EXPECT_TRUE(reason("edges, \"tip SA1\"").starts_with("built"));
    EXPECT_TRUE(reason("edges, \"tip RA\"").starts_with("built"));
    EXPECT_NE(reason("contact, \"tip RA\"").find("corner frequency"), std::string::npos);
    EXPECT_NE(reason("edges, \"tip PC\"").find("fields are as wide as the skin"), std::string::npos);
    EXPECT_NE(reason("contact, \"plain\"").find("no positions"), std::string::npos);
    EXPECT_NE(reason("edges, \"plain\"").find("no positions"), std::string::npos);
    EXPECT_NE(reason("contact, \"few\"").find("too few: 2 afferents, at least 3"), std::string::npos);
    EXPECT_NE(reason("edges, \"few\"").find("too few: 2 afferents, at least 8"), std::string::npos);
    EXPECT_TRUE(reason("edges, \"eight\"").starts_with("built")) << reason("edges, \"eight\"");
    EXPECT_NE(reason("contact, \"slope\"").find("not sustained"), std::string::npos);
    EXPECT_NE(reason("contact, \"many\"").find("too many: 1600 afferents, at most 1024"), std::string::npos);
    const Plan unasked = make_plan(Scene::from_text("patch { name: 'a' }"));
    EXPECT_TRUE(std::any_of(unasked.items.begin(), unasked.items.end(), [](const PlanItem& part) {
        return !part.built && part.reason == "decoder.contact is not given";
    }));
}

// A neuron that is 15 mV below its threshold fires from 1.5 N on its element, whatever the size of a cell.
TEST(ReadoutPlans, LeaveOutAContactThatFullScaleDoesNotReach) {
    const auto reason = [](const std::string& full_scale_n) {
        const Plan plan = make_plan(Scene::from_text(
            "patch { name: 'skin' outline { rectangle { width_mm: 4 height_mm: 2 } pitch_mm: "
            "0.5 } encoder { sustained { gain_mv_per_n: 10 } } neuron { v_r_mv: -65 v_th_mv: "
            "-50 } sensor { full_scale_n: " +
            full_scale_n +
            " } } patch { name: 'other' kind: SA1 outline {} } source { pushed {} } gain { "
            "accept_unreachable_limit: true } decoder { filter {} contact {} }"));
        for (const PlanItem& part : plan.items)
            if (part.name == "read-out of contact, \"skin\"")
                return (part.built ? "built: " : "") + part.reason;
        return std::string("none");
    };
    EXPECT_EQ(reason("1.5"), "an afferent is silent up to its sensors' full scale");
    EXPECT_TRUE(reason("1.51").starts_with("built")) << reason("1.51");
}

TEST(ReadoutPlans, RefuseWhatNoPatchCanHave) {
    EXPECT_NE(why_not("decoder { filter {} contact {} }").find("decoder.contact"), std::string::npos);
    EXPECT_NE(why_not("decoder { filter {} contact {} }").find("no positions: outline is not given"),
              std::string::npos);
    EXPECT_NE(why_not("decoder { edge {} }").find("decoder.edge"), std::string::npos);
    EXPECT_NE(why_not("decoder { texture {} }").find("decoder.texture"), std::string::npos);
}

TEST(ReadoutPlans, OfAContactAreTheSameBesideEveryDecoder) {
    const auto parameters = [](const std::string& decoder) {
        return make_plan(
                   Scene::from_text("duration_s: 1 patch { name: 'skin' kind: SA1 outline {} } source { "
                                    "edge {} } record { force: false } decoder { contact {} " +
                                    decoder + " }"))
            .controller.value()
            .readouts.parameters;
    };
    ASSERT_EQ(parameters("").size(), 1U);
    EXPECT_EQ(parameters(""), parameters("filter {}"));
    EXPECT_EQ(parameters("interval {}"), parameters("filter {}"));
}

// The negative half-wave of RA is 0.12 of the positive one, so that an RA fires at a fall 1/0.12 times as
// large as the rise at which it fires. PC do not take part, since the slope does not drive them.
TEST(ReadoutPlans, OfAContactHaveTheTransientAfferentsOnTheSameSkin) {
    const std::string tip =
        "patch { name: 'tip' kinds: [SA1, RA, PC] outline {} } patch { name: 'other' kind: RA outline {} } "
        "source { pushed {} } decoder { filter {} contact {} ";
    const auto contact_of = [](const std::string& text) {
        return std::get<ContactReadout::Parameters>(controller_of(text).readouts.parameters.at(0));
    };
    const Plan plan = make_plan(Scene::from_text(tip + "}"));
    const PatchPlan& ra = plan.patches[1];
    const auto transients = contact_of(tip + "}").transients;
    ASSERT_EQ(transients.size(), ra.afferents());
    for (std::size_t i = 0; i < transients.size(); ++i) {
        EXPECT_EQ(transients[i].address, ra.first + i);
        EXPECT_NEAR(transients[i].rise_n_per_mm2 / transients[i].fall_n_per_mm2, 0.12, 1e-12);
        EXPECT_DOUBLE_EQ(transients[i].tau_m_s, 0.034);
        EXPECT_GT(transients[i].rise_n_per_mm2, 0);
    }
    EXPECT_TRUE(contact_of(tip + "patch: 'tip SA1' }").transients.empty());
    EXPECT_TRUE(
        contact_of("patch { name: 'tip' kind: SA1 outline {} } source { pushed {} } decoder { filter {} "
                   "contact {} }")
            .transients.empty());
    // Afferents that only a rise drives tell of no fall.
    EXPECT_TRUE(
        contact_of(
            "patch { name: 'tip' kind: SA1 outline {} } patch { name: 'rises' elements_of: 'tip' kind: RA "
            "encoder { transient { negative_ratio: 0 } } } source { pushed {} } decoder { filter {} contact "
            "{} }")
            .transients.empty());
    const std::string says = "how they fall by " + std::to_string(transients.size()) + " transient ones";
    EXPECT_TRUE(std::any_of(plan.items.begin(), plan.items.end(), [&](const PlanItem& part) {
        return part.built && part.name == "read-out of contact, \"tip SA1\"" &&
               part.reason.find(says) != std::string::npos;
    }));
}

TEST(ReadoutPlans, TellTheFieldsOfAfferents) {
    const auto contact = std::get<ContactReadout::Parameters>(
        controller_of(
            "patch { name: 'skin' outline { rectangle { width_mm: 12 height_mm: 8 } pitch_mm: 0.1 } "
            "afferents { field_sd_mm: 0.5 place { x_mm: 1 y_mm: -2 } place { x_mm: 0.3 } place { "
            "x_mm: 6 } } encoder { sustained { gain_mv_per_n: 12000 } } } source { pushed {} } "
            "decoder { filter {} contact {} }")
            .readouts.parameters.at(0));
    ASSERT_EQ(contact.afferents.size(), 3U);
    const SkinField& inner = contact.afferents[0].field;
    // Cells of 0.1 mm place it to a hundredth of them. Of a Gaussian, what lies within three standard
    // deviations has (1 − 10 e^(−4.5)·...) of the variance: 1 − 9/2 e^(−4.5)/(1 − e^(−4.5)).
    EXPECT_NEAR(inner.x_mm, 1, 1e-3);
    EXPECT_NEAR(inner.y_mm, -2, 1e-3);
    const double kept = 1 - 4.5 * std::exp(-4.5) / (1 - std::exp(-4.5));
    // The weights leave room for the aperture of an element; forces that are pushed are those on squares.
    const double weights_mm2 = 0.25 - 0.01 * Aperture::sd * Aperture::sd;
    EXPECT_NEAR(inner.variance_mm2, weights_mm2 * kept + 0.01 / 12, 0.01 * 0.25);
    // At the outline, half of the field is there, and its middle is √(2/π) of 0.5 mm inside.
    EXPECT_NEAR(contact.afferents[2].field.x_mm, 6 - 0.5 * std::sqrt(2 / 3.14159265), 0.02);
    // 15 mV, and 12 V for a newton on a square millimetre; at the outline, twice as much for half of the
    // field.
    EXPECT_NEAR(contact.afferents[0].unit_n_per_mm2, 15.0 / 12000 / 0.3, 2e-4);
    EXPECT_NEAR(contact.afferents[2].unit_n_per_mm2 / contact.afferents[0].unit_n_per_mm2, 2, 0.1);
    // A unit is what 0.3 newtons of grip are to the filter.
    EXPECT_NEAR(contact.afferents[0].group.threshold_n(), 0.3, 1e-9);
    EXPECT_EQ(contact.elements.size(), 120U * 80U);
    EXPECT_DOUBLE_EQ(contact.element_mm2, 0.1 * 0.1);
}

TEST(ReadoutPlans, TakeElementsForFieldsWhereEachHasItsOwnAfferent) {
    const auto contact = std::get<ContactReadout::Parameters>(
        controller_of(
            "patch { name: 'pad' outline { rectangle { width_mm: 4 height_mm: 4 } pitch_mm: 2 } encoder { "
            "sustained { "
            "gain_mv_per_n: 8 bias_mv: 11 } } } source { pushed {} } decoder { filter {} contact {} }")
            .readouts.parameters.at(0));
    ASSERT_EQ(contact.afferents.size(), 4U);
    EXPECT_EQ(contact.afferents[3].field, (SkinField{1, 1, 4.0 / 12}));
    // Half a newton on 4 mm².
    EXPECT_DOUBLE_EQ(contact.afferents[0].unit_n_per_mm2, 0.5 / 4 / 0.3);
}

// A force of 0.02 N on each element in the middle of a pad, of which the others feel nothing.
TEST(ReadoutPlans, ContinueFromASnapshotBitForBit) {
    const Scene scene = Scene::from_text(
        "patch { name: 'pad' outline { pitch_mm: 1 } kind: SA1 } source { pushed {} } link { in_process {} } "
        "decoder { filter {} contact {} edge { settle_ms: 20 } }");
    Coprocessor coprocessor(scene);
    Controller controller(scene);
    Controller other(scene);
    std::vector<double> forces_n(100);
    for (const std::size_t element : {44, 45, 54, 55}) forces_n[element] = 0.02;
    int contacts = 0;
    for (TimePoint now = scene_start; now < scene_start + 300ms; now += 5ms) {
        coprocessor.push({now, 0, forces_n});
        const auto events = coprocessor.advance(now + 5ms - 1ns);
        if (now == scene_start + 100ms) other.resume(controller.snapshot());
        for (Controller* each : {&controller, &other}) {
            each->observe(now, now + 5ms, events);
            each->step(now + 5ms, {User::rest_counts, User::rest_counts});
        }
        if (now < scene_start + 100ms) continue;
        ASSERT_EQ(other.last_step().readouts, controller.last_step().readouts);
        for (const PatchReadout& readout : controller.last_step().readouts) {
            const PatchContact& contact = std::get<PatchContact>(readout);
            ++contacts;
            EXPECT_GT(contact.estimate.afferents, 0U);
            // Between the elements that are pressed.
            EXPECT_NEAR(contact.estimate.x_mm, 0, 1);
            EXPECT_NEAR(contact.estimate.y_mm, 0, 1);
        }
    }
    EXPECT_EQ(contacts, 20) << "one each 10 ms";
    EXPECT_THROW(other.resume(Controller(Scene()).snapshot()), std::exception);
}

}  // namespace
}  // namespace afferent
