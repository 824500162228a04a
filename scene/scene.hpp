// A scene, read, checked and filled in: what everything else is built from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/proto/scene.pb.h"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/scene_text.hpp"

namespace afferent {

class Scene {
  public:
    // Throw SceneError, which names file, line, column, field and rule of everything that is wrong.
    static Scene from_file(const std::filesystem::path& file);
    // `folder` is what the paths in the scene are relative to.
    static Scene from_text(std::string_view text, std::string name = "scene",
                           std::filesystem::path folder = ".");

    // As written, with the default patches where there were none.
    const proto::Scene& description() const noexcept { return description_; }
    const std::string& name() const noexcept { return name_; }
    std::filesystem::path resolve(const std::string& path) const { return folder_ / path; }

    std::span<const Patch> patches() const noexcept { return patches_; }
    // Of neurons.
    std::uint32_t addresses() const noexcept { return addresses_; }
    // Of elements, each counted once however many neurons read it.
    std::uint32_t elements() const noexcept;

    Duration duration() const noexcept { return duration_; }
    std::uint64_t seed() const noexcept { return description_.seed(); }

    // The scene as it is now, in the text format: what from_text would read as the same scene.
    std::string text() const;

    // Of what both ends of a link have to agree on: patches, neurons, link, seed and duration; not of file
    // names.
    std::uint64_t fingerprint() const;

    // What the command line may say in the scene's place.
    void set_seed(std::uint64_t seed) { description_.set_seed(seed); }
    void set_table(const std::string& path);
    void set_emg_table(const std::string& path);

  private:
    Scene(SceneText& text, std::string name, std::filesystem::path folder);

    proto::Scene description_;
    std::string name_;
    std::filesystem::path folder_;
    std::vector<Patch> patches_;
    std::uint32_t addresses_ = 0;
    Duration duration_{};
};

// From a scene's seconds or milliseconds, to the nearest nanosecond.
Duration from_seconds(double seconds);
Duration from_milliseconds(double milliseconds);

// The link of a scene: transport and timing with its units in types.
struct LinkTiming {
    Duration tick;
    Duration packet;
    Duration delivery;
    Duration stale;  // the age from which on a packet is not used
    Duration heartbeat;
    Duration freeze;
    Duration safe;
};
LinkTiming link_timing(const proto::Link& link);

}  // namespace afferent
