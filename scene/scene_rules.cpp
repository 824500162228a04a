// The rules of everything in a scene but its patches.
#include <algorithm>

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/hand/emg_envelope.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/link_timing.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

constexpr double longest_s = 1e9;
constexpr double longest_ms = 10'000;

void require_path(const std::string& path, const char* field, const char* rule) {
    if (path.empty()) throw ParameterError(field, rule, "empty");
}

template <class Ported>
void check_port(const scene::Transport& transport, const char* field, bool has_channel) {
    const auto* at = std::get_if<Ported>(&transport);
    if (!at) return;
    require(at->port <= 65'535, field, "0 to 65535", at->port);
    // `afferent channel` takes the next one.
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
    require(at.baud >= 1200 && at.baud <= 4'000'000, "serial.baud", "1200 to 4000000", at.baud);
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
    require(link.tick_us >= 1 && link.tick_us <= 1000, "tick_us", "1 to 1000", link.tick_us);
    require(link.packet_ms >= 0.001 && link.packet_ms <= 1000, "packet_ms", "0.001 to 1000", link.packet_ms);
    const LinkTiming timing = link_timing(link);
    if (timing.packet % timing.tick != 0ns)
        throw ParameterError("packet_ms", "a multiple of tick_us", link.packet_ms);
    require(link.packet_events >= 1 && link.packet_events <= 50'000, "packet_events", "1 to 50000",
            link.packet_events);
    require(link.delivery_ms >= 0 && link.delivery_ms <= longest_ms, "delivery_ms", "0 to 10000",
            link.delivery_ms);
    require(link.heartbeat_ms >= link.packet_ms && link.heartbeat_ms <= longest_ms, "heartbeat_ms",
            ">= packet_ms and <= 10000", link.heartbeat_ms);
    require(link.stale_ms >= 0 && link.stale_ms <= 1e6, "stale_ms", "0 to 1000000", link.stale_ms);
    require(link.freeze_ms >= 2 * link.heartbeat_ms && link.freeze_ms <= 1e6, "freeze_ms",
            "at least twice heartbeat_ms and at most 1000000", link.freeze_ms);
    require(link.safe_ms > link.freeze_ms && link.safe_ms <= 1e6, "safe_ms",
            "> freeze_ms and at most 1000000", link.safe_ms);
    require(link.connect_s >= 0 && link.connect_s <= longest_s, "connect_s", "0 to 1e9", link.connect_s);
}

void check_channel(const scene::Link& link) {
    const scene::Channel& channel = *link.channel;
    if (std::holds_alternative<scene::InProcess>(link.transport))
        throw ParameterError("channel", "on a link with packets, tcp, unix_socket, udp or serial",
                             "in process");
    if (std::holds_alternative<scene::NamedPipes>(link.transport))
        throw ParameterError("channel",
                             "on a link that afferent channel can stand in, tcp, unix_socket, udp or serial",
                             "on named_pipes");
    require(channel.bandwidth_bps >= 0 && channel.bandwidth_bps <= 1e15, "bandwidth_bps", "0 to 1e15",
            channel.bandwidth_bps);
    require(channel.latency_ms >= 0 && channel.latency_ms <= longest_ms, "latency_ms", "0 to 10000",
            channel.latency_ms);
    require(channel.jitter_ms >= 0 && channel.jitter_ms <= longest_ms, "jitter_ms", "0 to 10000",
            channel.jitter_ms);
    for (const auto& [field, probability] :
         {std::pair("loss", channel.loss), std::pair("reorder", channel.reorder),
          std::pair("duplicate", channel.duplicate), std::pair("corrupt", channel.corrupt)})
        require(probability >= 0 && probability <= 1, field, "0 to 1", probability);
}

void check_profile(const scene::Profile& profile) {
    if (profile.point.empty()) throw ParameterError("profile.point", "given at least once", "none");
    double before_s = -1;
    for (const scene::ProfilePoint& point : profile.point) {
        require(point.time_s >= 0 && point.time_s > before_s && point.time_s <= longest_s,
                "profile.point.time_s", ">= 0 and increasing", point.time_s);
        require(point.force_n >= 0, "profile.point.force_n", ">= 0", point.force_n);
        before_s = point.time_s;
    }
}

void check_source(const scene::Source& source) {
    if (const auto* table = std::get_if<scene::Table>(&source))
        require_path(table->path, "table.path", "the path of a table");
    if (const auto* link = std::get_if<scene::LinkSource>(&source))
        require_path(link->table.path, "link.table.path", "the path of a table");
    if (const auto* profile = std::get_if<scene::Profile>(&source)) check_profile(*profile);
}

void check_decoder(const Scene& scene) {
    if (const auto* window = std::get_if<scene::SlidingWindow>(&scene.decoder.kind))
        require(window->window_ms > 0 && window->window_ms <= 60'000, "sliding_window.window_ms",
                "> 0 and <= 60000", window->window_ms);
    if (const auto* exponential = std::get_if<scene::Exponential>(&scene.decoder.kind))
        require(exponential->time_constant_ms > 0 && exponential->time_constant_ms <= 60'000,
                "exponential.time_constant_ms", "> 0 and <= 60000", exponential->time_constant_ms);
    for (const std::string& name : scene.decoder.patch) {
        const auto found = std::find_if(scene.patches.begin(), scene.patches.end(),
                                        [&](const scene::Patch& patch) { return patch.name == name; });
        if (found == scene.patches.end() || !std::holds_alternative<scene::Sustained>(found->encoder))
            throw ParameterError("patch", "a patch with a sustained encoder", "\"" + name + "\"");
    }
}

void check_hand(const scene::Hand& hand) {
    require(hand.emg_rate_hz >= 1 && hand.emg_rate_hz <= 100'000, "emg_rate_hz", "1 to 100000",
            hand.emg_rate_hz);
    require(hand.envelope_ms > 0 && hand.envelope_ms <= 1e6, "envelope_ms", "> 0 and <= 1000000",
            hand.envelope_ms);
    (void)Gripper(gripper_parameters(hand));
    if (!hand.emg_table) return;
    require_path(hand.emg_table->path, "emg_table.path", "the path of a table");
    require(hand.emg_table->full_scale_counts > 0, "emg_table.full_scale_counts", "> 0",
            hand.emg_table->full_scale_counts);
    require(true, "emg_table.rest_counts", "finite", hand.emg_table->rest_counts.value_or(0));
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

void check_scene(const Scene& scene, SceneFaults& faults) {
    faults.check("", "", [&] {
        require(scene.duration_s > 0 && scene.duration_s <= longest_s, "duration_s", "> 0 and <= 1e9",
                scene.duration_s);
    });
    faults.check("link", "", [&] {
        check_timing(scene.link);
        check_transport(scene.link);
    });
    if (scene.link.channel) faults.check("link.channel", "", [&] { check_channel(scene.link); });
    faults.check("source", "", [&] { check_source(scene.source); });
    faults.check("decoder", "", [&] { check_decoder(scene); });
    faults.check("gain", "", [&] { (void)EmgGain(scene.gain); });
    for (std::size_t i = 0; i < scene.output.size(); ++i)
        faults.check("output[" + std::to_string(i) + "]", "", [&] {
            require_path(std::get<scene::CommandFile>(scene.output[i]).path, "command_file.path",
                         "the path of a file");
        });
    faults.check("hand", "", [&] { check_hand(scene.hand); });
    faults.check("hand.user", "", [&] { (void)User(scene.hand.user, 0); });
    faults.check("runtime", "", [&] {
        require(scene.runtime.threads <= 1024, "threads", "0 to 1024", scene.runtime.threads);
        require(scene.runtime.spikes_per_window >= 1, "spikes_per_window", "at least 1",
                scene.runtime.spikes_per_window);
    });
}

}  // namespace afferent
