#include "afferent/scene/scene.hpp"

#include "afferent/scene/link_timing.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

std::string in_lines(const std::vector<std::string>& messages) {
    std::string text;
    for (const std::string& message : messages) text += (text.empty() ? "" : "\n") + message;
    return text;
}

}  // namespace

SceneError::SceneError(std::vector<std::string> messages)
    : std::runtime_error(in_lines(messages)), messages_(std::move(messages)) {}

void Scene::check() const {
    std::vector<std::string> messages;
    for (const SceneFault& fault : faults_of(*this)) messages.push_back(fault.path + ": " + fault.message());
    if (!messages.empty()) throw SceneError(std::move(messages));
}

TimePoint Scene::end() const { return scene_start + from_seconds(duration_s); }

std::uint64_t Scene::fingerprint() const {
    Scene agreed = *this;
    agreed.name.clear();
    agreed.record = {};
    agreed.runtime = {};
    agreed.output.clear();
    agreed.link.transport = {};
    agreed.link.keys.reset();
    agreed.link.connect_s = scene::Link().connect_s;
    if (agreed.hand.emg_table) agreed.hand.emg_table->path.clear();
    if (auto* table = std::get_if<scene::Table>(&agreed.source)) table->path.clear();
    if (auto* crossing = std::get_if<scene::LinkSource>(&agreed.source)) crossing->table.path.clear();
    std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
    for (const char byte : agreed.text()) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
    return hash;
}

Duration from_seconds(double seconds) { return rounded(Seconds(seconds)); }
Duration from_milliseconds(double milliseconds) { return rounded(Milliseconds(milliseconds)); }

LinkTiming link_timing(const scene::Link& link) {
    return {.tick = rounded(std::chrono::duration<double, std::micro>(link.tick_us)),
            .packet = from_milliseconds(link.packet_ms),
            .delivery = from_milliseconds(link.delivery_ms),
            .stale = from_milliseconds(link.delivery_ms + link.stale_ms),
            .heartbeat = from_milliseconds(link.heartbeat_ms),
            .freeze = from_milliseconds(link.freeze_ms),
            .safe = from_milliseconds(link.safe_ms)};
}

}  // namespace afferent
