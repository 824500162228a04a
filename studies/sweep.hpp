// Runs a scene with every combination of some of its fields' values, over the cores.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

// A field, by its path as in Setting, and the values that it takes.
struct SweepAxis {
    std::string path;
    std::vector<std::string> values;

    // From "path=value,value": commas within brackets, braces and quotes separate nothing. Throws SceneError.
    static SweepAxis from(std::string_view text);
};

// What a run came to.
struct RunFigures {
    double duration_s = 0;  // of the scene
    std::uint64_t events = 0;
    std::uint64_t packets = 0;
    std::uint64_t link_bytes = 0;  // with framing; 0 where the link carries no packets
    std::uint64_t raw_sample_bytes = 0;
    // The grip force's; nothing where the scene does not know the true one, or has no controller.
    std::optional<double> force_error_rms_n;
    std::optional<double> force_error_max_n;
    // The part of the steps whose error is within two sigmas.
    std::optional<double> within_two_sigmas;
    std::optional<double> lowest_gain;
    double run_time_s = 0;  // beside the other runs: the one figure that differs from sweep to sweep
};

struct SweepPoint {
    std::vector<Setting> settings;      // one of each axis
    std::optional<RunFigures> figures;  // nothing: not run
    std::string refusal;                // why not, or why it broke off; empty where it was not reached
};

struct SweepOptions {
    std::size_t threads = 0;  // 0, or more than the machine has: as many as it has
    // Called a few times a second, on the thread that called sweep(), with the fraction that is done; false
    // stops the sweep.
    std::function<bool(double fraction)> progress = {};
};

inline constexpr std::size_t most_sweep_points = 100'000;

// The points in the order of counting, the last axis fastest; each is run on one thread, and no command goes
// anywhere. A combination that is no scene is a point with a refusal. The same figures for any number of
// threads. Throws SceneError where there is no axis, an axis without values, or too many combinations, and
// where no combination is a scene.
std::vector<SweepPoint> sweep(const Scene& scene, std::span<const SweepAxis> axes,
                              const SweepOptions& options = {});

}  // namespace afferent
