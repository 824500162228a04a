#include "afferent/scene/scene.hpp"

#include <sstream>

#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

std::string in_lines(const std::vector<std::string>& messages) {
    std::string text;
    for (const std::string& message : messages) text += (text.empty() ? "" : "\n") + message;
    return text;
}

constexpr std::uint64_t fnv_begin = 0xcbf29ce484222325;
// FNV-1a.
constexpr std::uint64_t fnv_step(std::uint64_t hash, char byte) {
    return (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
}

// What two ends that can talk to each other have in common.
std::string agreed_text(const Scene& scene, Scene::TextLayout layout) {
    Scene agreed = scene;
    agreed.name.clear();
    // A plan's scene has what another leaves to the default.
    if (agreed.duration_s == scene::default_duration_s) agreed.duration_s.reset();
    agreed.record = {};
    agreed.runtime = {};
    agreed.output.clear();
    agreed.trial.reset();
    agreed.uncertainty = {};
    agreed.gain.accept_unreachable_limit = false;
    for (scene::Patch& patch : agreed.patches) patch.of_kind.reset();
    agreed.link.transport = {};
    agreed.link.keys.reset();
    agreed.link.connect_s = scene::Link().connect_s;
    if (agreed.hand.emg_table) agreed.hand.emg_table->path.clear();
    if (auto* const chip = std::get_if<scene::Chip>(&agreed.source)) *chip = {};
    if (agreed.hand.ability_hand) agreed.hand.ability_hand->port.clear();
    if (scene::Table* const table = force_table(agreed.source)) table->path.clear();
    return agreed.text(layout);
}

}  // namespace

SceneError::SceneError(std::vector<std::string> messages)
    : std::runtime_error(in_lines(messages)), messages_(std::move(messages)) {}

void Scene::check() const {
    std::vector<std::string> messages;
    for (const SceneFault& fault : faults_of(*this)) messages.push_back(fault.path + ": " + fault.message());
    if (!messages.empty()) throw SceneError(std::move(messages));
}

TimePoint Scene::end() const {
    return scene_start + from_seconds(duration_s.value_or(scene::default_duration_s));
}

std::uint64_t Scene::fingerprint() const {
    std::uint64_t hash = fnv_begin;
    for (const char byte : agreed_text(*this, TextLayout::one_line)) hash = fnv_step(hash, byte);
    return hash;
}

// In the text each field has a line, and its own fields are indented by two.
std::map<std::string, std::uint32_t> Scene::part_fingerprints() const {
    std::map<std::string, std::uint64_t> hashes;
    std::string outer;
    std::string inner;
    std::istringstream text(agreed_text(*this, TextLayout::field_a_line));
    for (std::string line; std::getline(text, line);) {
        const std::size_t indent = line.find_first_not_of(' ');
        const std::string word = line.substr(indent, line.find_first_of(": ", indent) - indent);
        if (word == "}" && indent < 4) continue;
        if (indent == 0) outer = inner = word;
        if (indent == 2) inner = outer + "." + word;
        // A message is told by its fields.
        if (indent == 0 && line.ends_with('{')) continue;
        std::uint64_t& hash = hashes.try_emplace(inner, fnv_begin).first->second;
        for (const char byte : line) hash = fnv_step(hash, byte);
    }
    std::map<std::string, std::uint32_t> parts;
    for (const auto& [part, hash] : hashes)
        parts.emplace(part, static_cast<std::uint32_t>(hash ^ (hash >> 32)));
    return parts;
}

}  // namespace afferent
