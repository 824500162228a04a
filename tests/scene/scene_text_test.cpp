// A scene's text and its value are equivalent.
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

#include "afferent/proto/scene.pb.h"
#include "afferent/scene/fields.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {
namespace {

// A scene in which nothing has its default.
Scene elaborate() {
    Scene scene;
    scene.name = "elaborate";
    scene.duration_s = 3.25;
    scene.seed = 77;
    scene::Patch patch{.name = "a", .elements = 2, .share = {0.25, 0.5}};
    patch.sensor.adc_bits = 10;
    patch.sensor.rate_hz = 250;
    patch.sensor.force_resistance.emplace().half_force_n = 0.7;
    patch.sensor.calibration = {{0, 0}, {1023, 9}};
    patch.sensor.dead_element = {1};
    patch.sensor.stuck_element = {{.element = 0, .force_n = 1}};
    patch.sensor.out_of_range = scene::OutOfRange::refuse;
    patch.neuron.tau_m_ms = 7;
    patch.neuron.tuning.rate = RateKind::onset;
    patch.neuron.tuning.rate_hz = 50;
    patch.neuron.form = scene::Form::sparse;
    scene.patches = {patch, {.name = "b", .elements_of = "a"}};
    scene.patches[1].field = {{.weight = {{.element = 0, .weight = 0.5}, {.element = 1, .weight = 2}}}};
    // Its effect is that of no bias; as an optional it is present.
    scene.patches[1].encoder = scene::Transient{.gain_mv_s_per_n = 0.5, .bias_mv = 0.0};
    scene.source = scene::Profile{{{.time_s = 0, .force_n = 1}, {.time_s = 2, .force_n = 3}}};
    scene.link.transport = scene::Tcp{.host = "127.0.0.2", .port = 7451};
    scene.link.keys = "keys";
    scene.link.encoding = scene::Encoding::fixed_width;
    scene.link.channel.emplace().loss = 0.125;
    scene.link.bus.emplace();
    scene.decoder.kind = scene::Exponential{.time_constant_ms = 20};
    scene.decoder.pooling = Pooling::per_neuron;
    scene.decoder.patch = {"a"};
    scene.decoder.parts = scene::Parts::elements;
    scene.gain = scene::Gain{{.onset_n = 1,
                              .lambda_n = 2,
                              .limit_n = 7,
                              .shape = EmgGain::Shape::continuous,
                              .upper_bound_sigmas = 1.5,
                              .doubtful = EmgGain::Doubtful::as_estimated,
                              .saturated = 0.1},
                             true};
    scene.uncertainty = {.gain = 0.02,
                         .common_gain = 0.03,
                         .share = 0.2,
                         .share_time_s = 0.5,
                         .offset_n = 0.04,
                         .hysteresis = 0.06,
                         .adaptation = 0.07};
    scene.output = {scene::CommandFile{"commands.csv"}};
    scene.hand.emg_table =
        scene::EmgTable{.path = "emg.csv", .rest_counts = 0.0, .between = scene::Between::hold};
    scene.hand.motor.dead_band = 0.05;
    scene.hand.safe_state = SafeState::open;
    scene.hand.rearm = Rearm::by_user;
    scene.record.picture = false;
    scene.runtime.threads = 2;
    scene.runtime.skip_scans_after_ms = 20;
    return scene;
}

bool equal(const Scene& a, const Scene& b) {
    return a.name == b.name && a.duration_s == b.duration_s && a.seed == b.seed && a.patches == b.patches &&
           a.source == b.source && a.link == b.link && a.decoder == b.decoder && a.gain == b.gain &&
           a.uncertainty == b.uncertainty && a.output == b.output && a.hand == b.hand &&
           a.record == b.record && a.runtime == b.runtime && a.trial == b.trial;
}

TEST(SceneText, IsEmptyForASceneOfDefaults) { EXPECT_EQ(Scene().text(), ""); }

TEST(SceneText, ReadsTheSceneThatItWasWrittenFrom) {
    const Scene scene = elaborate();
    EXPECT_TRUE(equal(Scene::from_text(scene.text()), scene)) << scene.text();
    EXPECT_EQ(Scene::from_text(scene.text()).text(), scene.text());
    int examples = 0;
    for (const auto& entry : std::filesystem::directory_iterator(AFFERENT_SOURCE_DIR "/examples")) {
        if (entry.path().extension() != ".txtpb") continue;
        ++examples;
        const Scene example = Scene::from_file(entry.path());
        const Scene read = Scene::from_text(example.text());
        EXPECT_TRUE(equal(read, example)) << entry.path();
        EXPECT_EQ(read.fingerprint(), example.fingerprint());
    }
    EXPECT_GE(examples, 4);
}

TEST(SceneText, TakesTheWindowOfTheDecoderAsAShorthand) {
    EXPECT_TRUE(equal(Scene::from_text("decoder { window_ms: 80 }"),
                      Scene::from_text("decoder { sliding_window { window_ms: 80 } }")));
}

// A scene that is built in code is refused for the same reasons, by the path of the field.
TEST(SceneText, IsCheckedAsASceneBuiltInCodeIs) {
    Scene scene;
    scene.patches[1].neuron.tau_m_ms = -10;
    try {
        scene.check();
        FAIL();
    } catch (const SceneError& error) {
        EXPECT_STREQ(
            error.what(),
            "patch[1].neuron.tau_m_ms: patch \"index\": neuron.tau_m_ms must be 1e-6 to 1e6, is -10");
    }
    EXPECT_NO_THROW(elaborate().check());
}

// Walking over the fields meets each field of the schema, so that a new one cannot be forgotten. The defaults
// of both are the same, so that leaving a field out of the text means the same as leaving it out of the code.
class Walk {
  public:
    explicit Walk(const google::protobuf::Descriptor* type) : type_(*type) {}

    // The range of a number stands in a comment behind it, where people look for it.
    template <class T>
    void operator()(const RangedName& ranged, const T& member) {
        (*this)(ranged.name, member);
        static const std::map<std::string, std::string> comments = numbers_of_the_schema();
        const auto found = comments.find(type_.name() + "." + ranged.name);
        ASSERT_NE(found, comments.end()) << type_.name() << "." << ranged.name;
        EXPECT_EQ(found->second, ranged.range.text()) << type_.name() << "." << ranged.name;
    }

    template <class T>
    void operator()(const char* name, const T& member) {
        const auto* field = type_.FindFieldByName(name);
        ASSERT_TRUE(field) << type_.name() << "." << name;
        met_.insert(name);
        if constexpr (std::is_same_v<T, double>)
            EXPECT_EQ(member, field->default_value_double()) << type_.name() << "." << name;
        else if constexpr (std::is_same_v<T, bool>)
            EXPECT_EQ(member, field->default_value_bool()) << type_.name() << "." << name;
        else if constexpr (std::is_same_v<T, std::uint32_t>)
            EXPECT_EQ(member, field->default_value_uint32()) << type_.name() << "." << name;
        else if constexpr (std::is_same_v<T, std::uint64_t>)
            EXPECT_EQ(member, field->default_value_uint64()) << type_.name() << "." << name;
        else if constexpr (std::is_same_v<T, std::string>)
            EXPECT_EQ(member, field->default_value_string()) << type_.name() << "." << name;
        else if constexpr (std::is_enum_v<T>)
            EXPECT_EQ(static_cast<int>(member), field->default_value_enum()->number())
                << type_.name() << "." << name;
        else
            enter(field->message_type(), member);
    }

    template <class... T>
    void arms(const std::variant<T...>& variant) {
        walk_arms(type_, variant, met_);
    }

    // Fields that only the text has.
    void expect_all_but(const std::set<std::string>& shorthands) const {
        for (int i = 0; i < type_.field_count(); ++i) {
            const std::string& name = type_.field(i)->name();
            EXPECT_NE(met_.contains(name), shorthands.contains(name)) << type_.name() << "." << name;
        }
    }

  private:
    // By the names of message and field: the comment at the end of its line.
    static std::map<std::string, std::string> numbers_of_the_schema() {
        const std::regex number("^ +(?:optional|repeated) (?:double|uint32) (\\w+) =[^/]*// (.*)$");
        std::ifstream in(AFFERENT_SOURCE_DIR "/proto/scene.proto");
        std::map<std::string, std::string> found;
        std::string message;
        std::smatch parts;
        for (std::string line; std::getline(in, line);) {
            if (line.starts_with("message ")) message = line.substr(8, line.find(' ', 8) - 8);
            if (std::regex_match(line, parts, number)) found[message + "." + parts.str(1)] = parts.str(2);
        }
        return found;
    }

    template <class T>
    static constexpr bool is_struct = std::is_class_v<T> && !std::is_same_v<T, std::string>;

    template <class T>
    static void walk(const google::protobuf::Descriptor* type, const T& value) {
        Walk inner(type);
        each_field(value, inner);
        static const std::map<std::string, std::set<std::string>> shorthands{
            {"Scene", {"every_patch"}},
            {"Patch", {"kind", "kinds", "per_cm2"}},
            {"Afferents", {"places"}},
            {"Decoder", {"window_ms"}}};
        const auto found = shorthands.find(type->name());
        inner.expect_all_but(found == shorthands.end() ? std::set<std::string>() : found->second);
    }

    template <class... T>
    static void walk_arms(const google::protobuf::Descriptor& type, const std::variant<T...>&,
                          std::set<std::string>& met) {
        std::size_t index = 0;
        const auto arm = [&](const auto& value) {
            const char* name = alternative_names<std::variant<T...>>[index++];
            if (!*name) {
                Walk fields(&type);
                each_field(value, fields);
                met.insert(fields.met_.begin(), fields.met_.end());
                return;
            }
            const auto* field = type.FindFieldByName(name);
            ASSERT_TRUE(field) << type.name() << "." << name;
            met.insert(name);
            walk(field->message_type(), value);
        };
        (arm(T{}), ...);
        EXPECT_EQ(alternative_names<std::variant<T...>>.size(), index);
    }

    template <class T>
    static void enter(const google::protobuf::Descriptor* type, const T& value) {
        walk(type, value);
    }
    template <class... T>
    static void enter(const google::protobuf::Descriptor* type, const std::variant<T...>& value) {
        std::set<std::string> met;
        walk_arms(*type, value, met);
        EXPECT_EQ(static_cast<std::size_t>(type->field_count()), met.size()) << type->name();
    }
    template <class T>
    static void enter(const google::protobuf::Descriptor* type, const std::optional<T>&) {
        if constexpr (is_struct<T>) enter(type, T{});
    }
    template <class T>
    static void enter(const google::protobuf::Descriptor* type, const std::vector<T>&) {
        if constexpr (is_struct<T>) enter(type, T{});
    }

    friend class SceneFields_AreThoseOfTheSchemaWithTheSameDefaults_Test;
    const google::protobuf::Descriptor& type_;
    std::set<std::string> met_;
};

TEST(SceneFields, AreThoseOfTheSchemaWithTheSameDefaults) { Walk::walk(proto::Scene::descriptor(), Scene()); }

}  // namespace
}  // namespace afferent
