// What the decoding benchmark decodes: forces that change over time, and the samples and events they lead to.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "afferent/decoders/decoded_afferents.hpp"
#include "bench/link_activity.hpp"

namespace afferent {

// One force, by itself: all elements feel a share of it.
struct TouchedForce {
    // From step to step of the benchmark: the force, and what the sensors read of it, linear between scans.
    std::vector<double> true_n;
    std::vector<double> sensed_n;
    LinkActivity activity;
    DecodedAfferents afferents;
    std::vector<double> share;  // by element
    // By count: the standard deviation of a reading, of the sensor's noise and of its converter's steps.
    std::vector<double> noise_n;

    // What a decoder can find with what it has been told: the true force, or where the sensors have a
    // hysteresis that it was not told of, the sensed one.
    bool hysteresis_is_known = true;
    const std::vector<double>& decodable_n() const noexcept {
        return hysteresis_is_known ? true_n : sensed_n;
    }
    bool touched() const noexcept;
};

struct Touch {
    static constexpr Duration step = 1ms;

    std::string name;
    std::vector<TouchedForce> forces;
    LinkActivity activity;  // of all of them, on one link

    Touch(std::string called, std::vector<TouchedForce> together);
    std::uint32_t elements() const noexcept { return activity.elements; }
    // How many of the forces are touched at all.
    std::size_t touched() const noexcept;
    // How far the touched forces wander in a second, squared, in the mean over the scene: Σ(ΔF)²/t from scan
    // to scan, the maximum-likelihood estimate for a Wiener process.
    double wander_n2_per_s() const noexcept;
};

// The scene's sensors, encoders and neurons under that force. The scene's link and hand do not count.
TouchedForce touched_force(const Scene& scene, Duration duration, const GripForce& force_n);

// `elements` of one patch with these shares, and neurons that fire at 100 Hz at the given grip force.
Scene plain_scene(std::vector<double> share, double full_scale_n, double tuned_n);

// Shares as curved fingertips give them: those of examples/grasp.txtpb.
inline const std::vector<double> nine_shares{0.20, 0.18, 0.12, 0.11, 0.10, 0.06, 0.10, 0.08, 0.05};

// A table of forces in newtons.
struct RecordedForces {
    std::string name;   // the file's, without its extension
    Duration duration;  // at most 20 s
    std::vector<GripForce> columns;
};
// Those of a folder, by name. Says on standard error where there are none.
std::vector<RecordedForces> recorded_forces(const std::filesystem::path& folder);

struct TouchOptions {
    std::vector<std::string> scenes = {};  // files; none: the benchmark's own
    std::filesystem::path examples = "examples";
    std::filesystem::path data = "../shared/data";  // tables of forces in newtons; may be absent
    bool quick = false;
};

// The touches that every scheme is compared on; their forces do not depend on what a hand would have done.
// Without scenes: the grasp with its hysteresis, with a decoder that is not told of it, and without it; the
// paper's neuron; each table with one neuron and with nine, or for several columns with one neuron each; and
// 1,000 elements of which a tenth is touched. Says on standard error which tables are absent. Throws
// SceneError or std::runtime_error.
std::vector<Touch> touches(const TouchOptions& options);

}  // namespace afferent
