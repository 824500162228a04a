// A scene: the complete input of Afferent, as a value, built in code or read from text. Included by programs
// that build or read scenes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/runtime/time.hpp"
#include "afferent/scene/decoder.hpp"
#include "afferent/scene/hand.hpp"
#include "afferent/scene/link.hpp"
#include "afferent/scene/output.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/scene_error.hpp"
#include "afferent/scene/setting.hpp"
#include "afferent/scene/source.hpp"
#include "afferent/scene/trial.hpp"

namespace afferent {

// The structs of a scene, with a header for each topic. Members have the names and defaults of
// proto/scene.proto, which documents each of them.
namespace scene {

inline constexpr double default_duration_s = 10;

struct Record {
    bool events = true;
    bool force = true;
    bool picture = true;
    bool operator==(const Record&) const = default;
    static void fields(auto& self, auto&& f) {
        f("events", self.events);
        f("force", self.force);
        f("picture", self.picture);
    }
};

struct Runtime {
    std::uint32_t threads = 0;
    std::uint32_t spikes_per_window = 1000;
    std::optional<double> skip_scans_after_ms = {};
    bool operator==(const Runtime&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("threads", 0, 1024), self.threads);
        f(within("spikes_per_window", 1, 1e9), self.spikes_per_window);
        f(within("skip_scans_after_ms", 1, 60000), self.skip_scans_after_ms);
    }
};

}  // namespace scene

// The defaults are those of the paper: nine elements on three fingers, and a simulated hand.
//
//     Scene scene;
//     scene.patches = {{.name = "thumb", .elements = 3}};
//     scene.link.transport = scene::Tcp{.port = 7450};
//     scene.check();
struct Scene {
    std::string name = {};
    // Absent: the length of the table of forces if there is one, otherwise 10 s. Always present in the scene
    // of a plan.
    std::optional<double> duration_s = {};
    std::uint64_t seed = 1;
    std::vector<scene::Patch> patches = {{.name = "thumb"}, {.name = "index"}, {.name = "middle"}};
    scene::Source source = {};
    scene::Link link = {};
    scene::Decoder decoder = {};
    scene::Gain gain = {};
    Uncertainty uncertainty = {};
    std::vector<scene::Output> output = {};
    scene::Hand hand = {};
    scene::Record record = {};
    scene::Runtime runtime = {};
    std::optional<scene::Trial> trial = {};
    static void fields(auto& self, auto&& f) {
        f("name", self.name);
        f(above("duration_s", 0, 1e9), self.duration_s);
        f("seed", self.seed);
        f("patch", self.patches);
        f("source", self.source);
        f("link", self.link);
        f("decoder", self.decoder);
        f("gain", self.gain);
        f("output", self.output);
        f("hand", self.hand);
        f("record", self.record);
        f("runtime", self.runtime);
        f("trial", self.trial);
        f("uncertainty", self.uncertainty);
    }

    // Not part of the scene itself: its name in messages, and the folder to which paths are relative.
    std::string file = "scene";
    std::filesystem::path folder = ".";

    // Read and check a scene, with settings applied in order. Throw SceneError, which lists file, line,
    // column, field and rule of every error.
    static Scene from_file(const std::filesystem::path& file, std::span<const Setting> settings = {});
    static Scene from_text(std::string_view text, std::string file = "scene",
                           std::filesystem::path folder = ".", std::span<const Setting> settings = {});
    // A copy with the settings applied, checked. Throws SceneError if a setting or the result is invalid.
    Scene with(std::span<const Setting> settings) const;
    // The fields that differ from the defaults. from_text reads the text back to the same scene.
    enum class TextLayout { one_line, field_a_line };
    std::string text(TextLayout layout = TextLayout::one_line) const;

    // Throws SceneError if the scene is invalid, with the path of each wrong field, as in
    // "patch[0].neuron.tau_m_ms", and the rule that it breaks. A scene that passes can be planned and run.
    void check() const;

    TimePoint end() const;
    std::filesystem::path resolve(const std::string& path) const { return folder / path; }

    // Equal for two ends that can communicate. Covers patches, neurons, link, seed and duration, but not
    // addresses, the name of the scene, recording and runtime.
    std::uint64_t fingerprint() const;
    // The same for single fields, by name: "seed", "link.packet_ms", "patch.neuron". Omits fields at their
    // default; all patches are combined.
    std::map<std::string, std::uint32_t> part_fingerprints() const;
};

}  // namespace afferent
