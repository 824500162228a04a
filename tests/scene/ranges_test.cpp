// Every number of a scene has a range, and a scene with anything in it can be planned and built, or is
// refused.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>
#include <typeinfo>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/runtime/spike_storm.hpp"
#include "afferent/scene/fields.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/long_runs.hpp"

namespace afferent {
namespace {

struct Number {
    std::string field;  // with the type of its struct
    std::string path;
    FieldRange range;
    bool whole;
    std::function<void(double)> set;
};

template <class T>
constexpr bool has_no_fields = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>;

// All numbers of a scene, to be set one by one.
class Numbers {
  public:
    explicit Numbers(std::vector<Number>& all) : all_(all) {}

    template <class T>
    void operator()(const RangedName& field, T& value) const {
        if constexpr (std::is_arithmetic_v<T>)
            add<T>(field, "", [&value](T to) { value = to; });
        else if constexpr (requires { value.has_value(); })
            add<typename T::value_type>(field, "", [&value](auto to) { value = to; });
        else
            add<typename T::value_type>(field, "[0]", [&value](auto to) {
                value.resize(std::max<std::size_t>(1, value.size()));
                value.front() = to;
            });
    }

    template <class T>
    void operator()(const char* name, T& value) const {
        if constexpr (has_no_fields<T>)
            return;
        else if constexpr (requires { value.index(); })
            inside<T>(name).arms(value);
        else if constexpr (requires { value.has_value(); }) {
            if (value) (*this)(name, *value);
        } else if constexpr (requires { value.size(); }) {
            if (!value.empty()) (*this)((name + std::string("[0]")).c_str(), value.front());
        } else
            each_field(value, inside<T>(name));
    }

    template <class Variant>
    void arms(Variant& variant) const {
        const char* name = alternative_names<Variant>[variant.index()];
        std::visit([&](auto& arm) { each_field(arm, inside<std::decay_t<decltype(arm)>>(name)); }, variant);
    }

  private:
    template <class T>
    Numbers inside(const std::string& name) const {
        Numbers inner = *this;
        if (!name.empty()) inner.path_ += name + ".";
        inner.type_ = typeid(T).name();
        return inner;
    }

    template <class T>
    void add(const RangedName& field, const char* index, const std::function<void(T)>& set) const {
        all_.push_back({type_ + std::string(" ") + field.name, path_ + field.name + index, field.range,
                        std::is_integral_v<T>, [set](double to) { set(static_cast<T>(to)); }});
    }

    std::vector<Number>& all_;
    std::string path_;
    const char* type_ = typeid(Scene).name();
};

// The numbers of every struct that a scene can have.
class Fields {
  public:
    explicit Fields(std::set<std::string>& all, const char* type = "") : all_(all), type_(type) {}

    template <class T>
    void operator()(const RangedName& field, const T&) const {
        all_.insert(type_ + std::string(" ") + field.name);
    }

    template <class T>
    void operator()(const char*, const T& value) const {
        if constexpr (has_no_fields<T>)
            return;
        else if constexpr (requires { value.index(); })
            arms(value);
        else if constexpr (requires { typename T::value_type; })
            (*this)("", typename T::value_type{});
        else
            each_field(value, Fields(all_, typeid(T).name()));
    }

    template <class... T>
    void arms(const std::variant<T...>&) const {
        ((*this)("", T{}), ...);
    }

  private:
    std::set<std::string>& all_;
    const char* type_;
};

// Together they have every struct of a scene.
std::vector<Scene> bases() {
    std::vector<Scene> scenes;
    const auto add = [&](auto&& change) {
        Scene scene;
        scene.patches = {{.name = "a", .elements = 2}};
        scene.gain.accept_unreachable_limit = true;
        change(scene);
        scenes.push_back(std::move(scene));
    };
    add([](Scene& scene) {
        scene.patches[0].sensor.force_resistance.emplace();
        scene.link.channel.emplace();
        scene.link.bus.emplace();
        scene.link.transport = scene::Udp();
        scene.trial.emplace();
        scene.trial->conditions = {{"rate", scene::Gain()}};
    });
    add([](Scene& scene) {
        scene.patches[0].neuron.delta_g = 0;
        scene.patches.push_back({.name = "b", .encoder = scene::Transient()});
        std::swap(scene.patches[0], scene.patches[1]);
        scene.patches[0].outline = scene::Outline{.shape = scene::Ellipse{2, 2}};
        scene.source = scene::Profile{{{.time_s = 0, .force_n = 1}}};
        scene.link.transport = scene::Tcp();
        scene.output = {scene::LiveEvents()};
        scene.link.encoding = scene::Encoding::fixed_width;
        scene.decoder.kind = scene::Exponential();
        scene.decoder.curve = RateKind::onset;
        scene.gain.brake.emplace();
    });
    add([](Scene& scene) {
        scene.patches[0].field = {{.weight = {{.element = 0, .weight = 1}}}};
        scene.patches[0].sensor.calibration = {{0, 0}, {4095, 10}};
        scene.patches[0].sensor.stuck_element = {{.element = 1, .force_n = 1}};
        scene.patches[0].neuron.tuning.rate = RateKind::onset;
        scene.decoder.pooling = Pooling::per_neuron;
        scene.decoder.parts = scene::Parts::elements;
        scene.hand.emg_table =
            scene::EmgTable{.path = "emg.csv", .rate_hz = 1000, .begin_s = 1, .full_scale_v = 0.001};
        scene.source = scene::Table{.path = "force.csv", .rate_hz = 100, .begin_s = 1};
        scene.duration_s = 1;
    });
    add([](Scene& scene) {
        scene.patches[0].encoder = scene::Sustained{.gain_mv_per_n = 2, .bias_mv = 1};
        scene.patches[0].neuron.form = scene::Form::dense;
        scene.decoder.kind = scene::Filter();
        scene.gain.pulse.emplace();
        scene.link.transport = scene::Serial{.device = "/dev/null"};
        scene.link.keys = "keys";
    });
    add([](Scene& scene) {
        scene.patches[0].encoder = scene::Sustained{
            .gain_mv_per_n = 1, .dynamic = scene::Dynamic(), .slow_adaptation = scene::SlowAdaptation()};
        scene.patches[0].neuron.fixed_point.emplace();
        scene.patches.push_back({.name = "b", .elements = 1});
        scene.source = scene::Pushed();
    });
    add([](Scene& scene) {
        scene::Patch& skin = scene.patches[0];
        skin.elements = scene::Patch().elements;
        skin.outline = scene::Outline{.shape = scene::Rectangle{2, 2}};
        skin.afferents = scene::Afferents{.place = {{.x_mm = 0.25, .y_mm = -0.5}}};
        skin.encoder = scene::Vibration{.gain_mv_s2_per_n = 1};
        skin.spread.gain = scene::Normal();
        skin.spread.threshold = scene::LogNormal();
        skin.spread.phase = scene::Uniform();
        skin.spread.time_class.resize(1);
        skin.nerve.emplace();
        scene.patches.push_back({.name = "b",
                                 .outline = scene::Outline{.shape = scene::Ellipse{2, 2}},
                                 .encoder = scene::Transient{.gain_mv_s_per_n = 1, .corner_hz = 50}});
        scene.source =
            scene::Touch{.skin = {.wave = SkinWave()},
                         .edge = {{}},
                         .indenter = {{.depth_mm = 0.1}},
                         .grating = {{}},
                         .dots = {{}},
                         .texture = {{}},
                         .grasp = {{.point = {{.force_n = 1}}, .contact = {{.patch = "a", .share = 0.5}}}}};
        scene.decoder.kind = scene::Filter();
        scene.record = {.events = true, .force = false, .picture = false};
    });
    add([](Scene& scene) {
        scene.patches[0].elements = scene::Patch().elements;
        scene.patches[0].outline = scene::Outline{.shape = scene::Rectangle{5, 5}};
        scene.source = scene::Pushed();
        scene.decoder.kind = scene::Filter();
        scene.decoder.contact.emplace();
        scene.decoder.edge.emplace();
        scene.decoder.texture.emplace();
    });
    add([](Scene& scene) {
        scene.patches[0].neuron.fixed_point = {.tick_us = 1000};  // ten times faster than the default
        scene.source = scene::Chip{.device = "tty"};
        scene.link.transport = scene::Tcp();
    });
    for (const scene::FingerDrive& drive : std::initializer_list<scene::FingerDrive>{
             scene::PositionDrive(), scene::VelocityDrive(), scene::CurrentDrive(), scene::DutyDrive()})
        add([&drive](Scene& scene) {
            scene.patches[0].elements = 30;
            scene.source = scene::HandSensors();
            scene.hand.ability_hand = scene::AbilityHand{
                .port = "hand.tty", .drive = drive, .zero_counts = std::vector<double>(30, 15)};
        });
    return scenes;
}

// Why the scene is refused; "accepted" if it is not, and has been built.
std::string outcome(const Scene& scene) {
    try {
        const Plan plan = make_plan(scene);
        Coprocessor coprocessor(plan);
        coprocessor.push({scene_start, 0, std::vector<double>(plan.elements, 1.0)});
        coprocessor.advance(scene_start + 10ms);
        if (plan.controller) Controller(plan).step(scene_start, {});
    } catch (const SceneError& error) {
        return error.what();
    } catch (const SpikeStormError&) {
    }
    return "accepted";
}

// Whether this machine has the memory for the most elements is not the subject.
bool can_be_built_here(const Number& number, double value) {
    return !number.path.ends_with("elements") || value <= 10'000;
}

class SceneRanges : public testing::TestWithParam<std::size_t> {};

TEST_P(SceneRanges, HoldWhatCanBePlannedAndBuilt) {
    const Scene base = bases().at(GetParam());
    Scene scene = base;
    std::vector<Number> numbers;
    each_field(scene, Numbers(numbers));
    std::size_t accepted = 0;
    for (const Number& number : numbers) {
        const FieldRange& range = number.range;
        std::vector<double> values{range.lowest, range.highest, 0, 1};
        if (long_runs)
            values.insert(values.end(), {std::nextafter(range.lowest, range.highest),
                                         std::nextafter(range.highest, range.lowest), 2});
        for (const double value : values) {
            if (!range.holds(value) || !can_be_built_here(number, value)) continue;
            scene = base;
            number.set(value);
            const std::string said = outcome(scene);
            EXPECT_EQ(said.find(" must be " + range.text()), std::string::npos)
                << number.path << ": " << said;
            if (said == "accepted") ++accepted;
        }
    }
    EXPECT_GT(accepted, (long_runs ? 2 : 1) * numbers.size()) << "most of it can be built";
}

TEST_P(SceneRanges, RefuseWhatIsBeyondThemByNameAndRange) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const Scene base = bases().at(GetParam());
    Scene scene = base;
    std::vector<Number> numbers;
    each_field(scene, Numbers(numbers));
    std::size_t refused = 0;
    for (const Number& number : numbers) {
        const FieldRange& range = number.range;
        for (const double value :
             {infinite, -infinite, std::nan(""), 1e308, -1e308, 1e-308, -1.0, 0.0, 4294967295.0,
              std::nextafter(range.lowest, -infinite), std::nextafter(range.highest, infinite)}) {
            const bool fits =
                !number.whole || (value >= 0 && value <= 4294967295.0 && value == std::floor(value));
            if (range.holds(value) || !fits) continue;
            scene = base;
            number.set(value);
            const std::string said = outcome(scene);
            EXPECT_EQ(said.rfind(number.path + ": ", 0), 0U) << number.path << " = " << value << ": " << said;
            EXPECT_NE(said.find(" must be " + range.text() + ", is "), std::string::npos) << said;
            ++refused;
        }
    }
    EXPECT_GT(numbers.size(), 50U);
    EXPECT_GT(refused, numbers.size());
}

INSTANTIATE_TEST_SUITE_P(SceneRanges, SceneRanges, testing::Range<std::size_t>(0, 12));

TEST(SceneRange, IsTriedForEveryNumber) {
    std::set<std::string> all;
    Fields{all}("", Scene());
    EXPECT_GT(all.size(), 100U);
    EXPECT_EQ(bases().size(), 12U) << "as many as the tests above are instantiated for";
    for (Scene& scene : bases()) {
        std::vector<Number> numbers;
        each_field(scene, Numbers(numbers));
        for (const Number& number : numbers) all.erase(number.field);
    }
    EXPECT_TRUE(all.empty()) << *all.begin();
}

TEST(SceneRange, IsReadEasily) {
    EXPECT_EQ(within("a", 0.001, 1000).range.text(), "0.001 to 1000");
    EXPECT_EQ(within("a", 1e-6, 16'777'216).range.text(), "1e-6 to 16777216");
    EXPECT_EQ(above("a", 0, 1e9).range.text(), "> 0 and at most 1e9");
    EXPECT_EQ(below("a", 0, 1).range.text(), ">= 0 and < 1");
}

}  // namespace
}  // namespace afferent
