#include "afferent/scene/scene_faults.hpp"

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Walks over the fields of a scene, and compares each number with its range.
class RangeCheck {
  public:
    explicit RangeCheck(SceneFaults& faults) : faults_(faults) {}

    template <class T>
    void operator()(const RangedName& field, const T& value) const {
        if constexpr (std::is_arithmetic_v<T>)
            compare(field.name, field.range, value);
        else if constexpr (requires { value.has_value(); }) {
            if (value) compare(field.name, field.range, *value);
        } else {
            for (std::size_t i = 0; i < value.size(); ++i) compare(at(field.name, i), field.range, value[i]);
        }
    }

    template <class T>
    void operator()(const char* name, const T& value) const {
        static_assert(!std::is_same_v<T, double> && !std::is_same_v<T, std::uint32_t>,
                      "a struct's fields have to say the range of each number");
        if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>)
            return;
        else if constexpr (requires { value.index(); })
            inside(name).arms(value);
        else if constexpr (requires { value.has_value(); }) {
            if (value) (*this)(name, *value);
        } else if constexpr (requires { value.size(); }) {
            for (std::size_t i = 0; i < value.size(); ++i) (*this)(at(name, i).c_str(), value[i]);
        } else {
            RangeCheck inner = inside(name);
            if constexpr (std::is_same_v<T, scene::Patch>) inner.about_ = about_patch(value.name);
            each_field(value, inner);
        }
    }

    template <class Variant>
    void arms(const Variant& variant) const {
        const char* name = alternative_names<Variant>[variant.index()];
        std::visit([&](const auto& arm) { each_field(arm, *name ? inside(name) : *this); }, variant);
    }

  private:
    static std::string at(const std::string& name, std::size_t index) {
        return name + "[" + std::to_string(index) + "]";
    }

    RangeCheck inside(const std::string& name) const {
        RangeCheck inner = *this;
        inner.path_ += (path_.empty() ? "" : ".") + name;
        return inner;
    }

    void compare(const std::string& name, const FieldRange& range, double value) const {
        if (range.holds(value)) return;
        faults_.check(path_, about_, [&] { throw ParameterError(name, range.text(), value); });
    }

    SceneFaults& faults_;
    std::string path_;
    std::string about_;
};

}  // namespace

bool SceneFaults::check(const std::string& path, const std::string& about,
                        const std::function<void()>& rule) {
    try {
        rule();
        return true;
    } catch (const ParameterError& error) {
        // "patch[1].neuron" is called "neuron" after the patch's name.
        const std::size_t dot = path.find('.');
        const std::string inner = about.empty() ? path : dot == std::string::npos ? "" : path.substr(dot + 1);
        add({.path = path + (path.empty() ? "" : ".") + error.field(),
             .about = about,
             .text = inner + (inner.empty() ? "" : ".") + error.what()});
        return false;
    }
}

std::string patch_path(std::size_t index) { return "patch[" + std::to_string(index) + "]"; }
std::string about_patch(const std::string& name) { return "patch \"" + name + "\""; }

bool check_ranges(const Scene& scene, SceneFaults& faults) {
    each_field(scene, RangeCheck(faults));
    return faults.none();
}

void check_scene(const Scene& scene, SceneFaults& faults) {
    check(scene.link, faults);
    check(scene.source, scene, faults);
    check(scene.decoder, scene, faults);
    check_gain(scene, faults);
    for (std::size_t i = 0; i < scene.output.size(); ++i) check(scene.output[i], i, faults);
    check(scene.hand, faults);
    if (scene.trial) check(*scene.trial, scene, faults);
}

void require_path(const std::string& path, const char* field, const char* rule) {
    if (path.empty()) throw ParameterError(field, rule, "empty");
}

}  // namespace afferent
