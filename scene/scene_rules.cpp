// The ranges of all fields of a scene, and the rules of everything in it but its patches.
#include <algorithm>

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/link_timing.hpp"
#include "afferent/scene/scene_faults.hpp"
#include "afferent/scene/scene_fields.hpp"

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
                      "scene_fields.hpp has to say the range of each number");
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
        const char* name = arm_names<Variant>[variant.index()];
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

void require_path(const std::string& path, const char* field, const char* rule) {
    if (path.empty()) throw ParameterError(field, rule, "empty");
}

template <class Ported>
void check_port(const scene::Transport& transport, const char* field, bool has_channel) {
    const auto* at = std::get_if<Ported>(&transport);
    if (!at) return;
    // `afferent channel` listens at the next port.
    if (has_channel)
        require(at->port < 65'535, field, "below 65535 where there is a channel, which takes the next one",
                at->port);
}

void check_unix_socket(const scene::UnixSocket& at, bool has_channel) {
    // The longest path that a socket's address holds.
    if (at.path.empty() || at.path.size() > 107)
        throw ParameterError("unix_socket.path", "1 to 107 characters", "\"" + at.path + "\"");
    if (has_channel)
        require(at.path.size() <= 99, "unix_socket.path", "at most 99 characters where there is a channel",
                static_cast<double>(at.path.size()));
}

void check_serial(const scene::Serial& at, bool has_keys) {
    require_path(at.device, "serial.device", "the path of a tty");
    if (!has_keys)
        throw ParameterError("serial", "on a link with keys, which afferent keys makes", "without");
}

void check_transport(const scene::Link& link) {
    const scene::Transport& transport = link.transport;
    check_port<scene::Tcp>(transport, "tcp.port", link.channel.has_value());
    check_port<scene::Udp>(transport, "udp.port", link.channel.has_value());
    if (const auto* at = std::get_if<scene::UnixSocket>(&transport))
        check_unix_socket(*at, link.channel.has_value());
    if (const auto* at = std::get_if<scene::Serial>(&transport))
        check_serial(*at, link.keys && !link.keys->empty());
    if (const auto* at = std::get_if<scene::File>(&transport))
        require_path(at->path, "file.path", "the path of a recording");
    if (const auto* at = std::get_if<scene::NamedPipes>(&transport))
        require_path(at->path, "named_pipes.path", "the path of the pipes, without their endings");
    if (!link.keys) return;
    require_path(*link.keys, "keys", "the path of a folder");
    if (!std::holds_alternative<scene::Tcp>(transport) && !std::holds_alternative<scene::Udp>(transport) &&
        !std::holds_alternative<scene::Serial>(transport))
        throw ParameterError("keys", "on a link that can leave the machine: tcp, udp or serial",
                             "on another");
}

void check_timing(const scene::Link& link) {
    const LinkTiming timing = link_timing(link);
    if (timing.packet % timing.tick != 0ns)
        throw ParameterError("packet_ms", "a multiple of tick_us", link.packet_ms);
    require(link.heartbeat_ms >= link.packet_ms, "heartbeat_ms", ">= packet_ms", link.heartbeat_ms);
    require(link.freeze_ms >= 2 * link.heartbeat_ms, "freeze_ms", "at least twice heartbeat_ms",
            link.freeze_ms);
    require(link.safe_ms > link.freeze_ms, "safe_ms", "> freeze_ms", link.safe_ms);
}

void check_channel(const scene::Link& link) {
    if (std::holds_alternative<scene::InProcess>(link.transport))
        throw ParameterError("channel", "on a link with packets, tcp, unix_socket, udp or serial",
                             "in process");
    if (std::holds_alternative<scene::NamedPipes>(link.transport))
        throw ParameterError("channel",
                             "on a link that afferent channel can stand in, tcp, unix_socket, udp or serial",
                             "on named_pipes");
}

void check_points(const std::vector<scene::ProfilePoint>& points, const std::string& field) {
    if (points.empty()) throw ParameterError(field, "given at least once", "none");
    double before_s = -1;
    for (const scene::ProfilePoint& point : points) {
        require(point.time_s > before_s, (field + ".time_s").c_str(), "increasing", point.time_s);
        before_s = point.time_s;
    }
}

void check_surface(const scene::Grating& grating) {
    require(grating.ridge_mm <= grating.period_mm, "ridge_mm", "at most period_mm", grating.ridge_mm);
}

void check_surface(const scene::Texture& texture) {
    constexpr double most_lengths = 32;  // each costs memory by its square
    require(texture.shortest_mm <= texture.longest_mm, "shortest_mm", "at most longest_mm",
            texture.shortest_mm);
    require(texture.longest_mm <= most_lengths * texture.shortest_mm, "longest_mm",
            "at most 32 times shortest_mm", texture.longest_mm);
}

void check_grasp(const scene::Grasp& grasp, const std::vector<scene::Patch>& patches) {
    check_points(grasp.point, "point");
    if (grasp.contact.empty()) throw ParameterError("contact", "given at least once", "none");
    double shares = 0;
    for (const scene::Contact& contact : grasp.contact) {
        shares += contact.share.value_or(0);
        const bool known =
            !contact.patch || std::any_of(patches.begin(), patches.end(),
                                          [&](const auto& each) { return each.name == *contact.patch; });
        if (!known)
            throw ParameterError("contact.patch", "the name of a patch", "\"" + *contact.patch + "\"");
    }
    require(shares <= 1 + 1e-9, "contact.share", "at most 1 in all", shares);
}

void check_touch(const Scene& scene, const scene::Touch& touch, SceneFaults& faults) {
    if (touch == scene::Touch{.skin = touch.skin})
        faults.add({"source", "", "source has no stimulus: an edge, indenter, grating, texture or grasp"});
    const auto check_each = [&](const auto& stimuli, const char* name, auto&& rule) {
        for (std::size_t i = 0; i < stimuli.size(); ++i)
            faults.check("source." + std::string(name) + "[" + std::to_string(i) + "]", "",
                         [&] { rule(stimuli[i]); });
    };
    check_each(touch.grating, "grating", [](const auto& grating) { check_surface(grating); });
    check_each(touch.texture, "texture", [](const auto& texture) { check_surface(texture); });
    check_each(touch.grasp, "grasp", [&](const auto& grasp) { check_grasp(grasp, scene.patches); });
}

void check_table(const scene::Table& table, const std::string& field) {
    require_path(table.path, (field + ".path").c_str(), "the path of a table");
    if (table.rate_hz && !table.time_column.empty())
        throw ParameterError(field + ".rate_hz", "absent where time_column is given", *table.rate_hz);
}

void check_source(const scene::Source& source) {
    if (const auto* table = std::get_if<scene::Table>(&source)) check_table(*table, "table");
    if (const auto* link = std::get_if<scene::LinkSource>(&source)) check_table(link->table, "link.table");
    if (const auto* profile = std::get_if<scene::Profile>(&source))
        check_points(profile->point, "profile.point");
}

void check_decoder(const Scene& scene) {
    if (scene.decoder.contact && !std::holds_alternative<scene::Filter>(scene.decoder.kind))
        throw ParameterError("contact", "beside the filter, which estimates its pressures: filter {}",
                             "beside another decoder");
    for (const std::string& name : scene.decoder.patch) {
        const auto found = std::find_if(scene.patches.begin(), scene.patches.end(),
                                        [&](const scene::Patch& patch) { return patch.name == name; });
        const bool both_kinds = std::holds_alternative<scene::Filter>(scene.decoder.kind);
        if (found == scene.patches.end())
            throw ParameterError("patch", "the name of a patch", "\"" + name + "\"");
        const auto* transient = std::get_if<scene::Transient>(&found->encoder);
        if (std::holds_alternative<scene::Vibration>(found->encoder) || (transient && transient->corner_hz))
            throw ParameterError("patch",
                                 "a patch whose encoder has no corner frequency, which no decoder inverts",
                                 "\"" + name + "\"");
        if (!both_kinds && !std::holds_alternative<scene::Sustained>(found->encoder))
            throw ParameterError("patch",
                                 "a patch with a sustained encoder, unless the decoder is the filter",
                                 "\"" + name + "\"");
    }
}

void check_hand(const scene::Hand& hand) {
    if (hand.emg_table) require_path(hand.emg_table->path, "emg_table.path", "the path of a table");
}

}  // namespace

Gripper::Parameters gripper_parameters(const scene::Hand& hand) {
    return {.time_constant_ms = hand.motor.time_constant_ms,
            .speed_mm_per_s = hand.motor.speed_mm_per_s,
            .force_limit_n = hand.motor.force_limit_n,
            .dead_band = hand.motor.dead_band,
            .stiffness_n_per_mm = hand.object.stiffness_n_per_mm,
            .distance_mm = hand.object.distance_mm};
}

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

bool check_ranges(const Scene& scene, SceneFaults& faults) {
    each_field(scene, RangeCheck(faults));
    return faults.none();
}

void check_scene(const Scene& scene, SceneFaults& faults) {
    faults.check("link", "", [&] {
        check_timing(scene.link);
        check_transport(scene.link);
    });
    if (scene.link.channel) faults.check("link.channel", "", [&] { check_channel(scene.link); });
    faults.check("source", "", [&] { check_source(scene.source); });
    if (const auto* touch = std::get_if<scene::Touch>(&scene.source)) check_touch(scene, *touch, faults);
    faults.check("decoder", "", [&] { check_decoder(scene); });
    faults.check("gain", "", [&] { (void)EmgGain(scene.gain); });
    for (std::size_t i = 0; i < scene.output.size(); ++i)
        faults.check("output[" + std::to_string(i) + "]", "", [&] {
            require_path(std::get<scene::CommandFile>(scene.output[i]).path, "command_file.path",
                         "the path of a file");
        });
    faults.check("hand", "", [&] { check_hand(scene.hand); });
    check_trial(scene, faults);
}

}  // namespace afferent
