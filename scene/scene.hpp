// A scene: everything that Afferent is told, as a value. Built in code, or read from text; both say the same.
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

// What a scene is made of, each topic in a header of its own. Members are called what they are called in the
// text, where proto/scene.proto tells what each means; the defaults are the same.
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

// The defaults are the paper's: nine elements on three fingers, a simulated hand.
//
//     Scene scene;
//     scene.patches = {{.name = "thumb", .elements = 3}};
//     scene.link.transport = scene::Tcp{.port = 7450};
//     scene.check();
struct Scene {
    std::string name = {};
    // None: as long as the table of forces, where there is one, and otherwise 10. A plan's scene always has
    // it.
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

    // Not part of the scene itself: its name in messages, and the folder that its paths are relative to.
    std::string file = "scene";
    std::filesystem::path folder = ".";

    // Read and checked. Throw SceneError, which tells file, line, column, field and rule of everything that
    // is wrong. Settings replace what the text says, in their order.
    static Scene from_file(const std::filesystem::path& file, std::span<const Setting> settings = {});
    static Scene from_text(std::string_view text, std::string file = "scene",
                           std::filesystem::path folder = ".", std::span<const Setting> settings = {});
    // This scene with these settings in place, checked. Throws SceneError.
    Scene with(std::span<const Setting> settings) const;
    // What differs from the defaults, as from_text reads it back to the same scene.
    enum class TextLayout { one_line, field_a_line };
    std::string text(TextLayout layout = TextLayout::one_line) const;

    // Throws SceneError, which names the path of each field that is wrong, as in "patch[0].neuron.tau_m_ms",
    // and the rule that it breaks. What passes can be planned, and run.
    void check() const;

    TimePoint end() const;
    std::filesystem::path resolve(const std::string& path) const { return folder / path; }

    // The same for two sides that can talk to each other: it covers patches, neurons, link, seed and
    // duration, but not where they meet, what the scene is called, and how it is recorded or carried out.
    std::uint64_t fingerprint() const;
    // The same for each of its fields and their fields, by name: "seed", "link.packet_ms", "patch.neuron".
    // Fields that are at their default are not among them; those of all patches count together.
    std::map<std::string, std::uint32_t> part_fingerprints() const;
};

}  // namespace afferent
