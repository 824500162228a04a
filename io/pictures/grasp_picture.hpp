// The picture of a run: grip force, spikes, spike rate and EMG gain over one time axis, as in the paper's
// Fig. 3.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/io/pictures/spike_density.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

struct GraspPicture {
    struct Level {
        std::string name;
        double force_n;
    };
    struct Patch {
        std::string name;
        Address first;
        std::uint32_t elements;
        bool transient = false;
    };
    // A patch or an element that has an estimate of its own.
    struct Part {
        std::string name;
        std::size_t patch;  // among `patches`
        std::vector<double> true_force_n;
        std::vector<double> estimate_n;
    };

    std::string title;  // may be empty
    double begin_s = 0;
    double end_s = 0;

    // Curves over `time_s`, each as long as it, or empty where there is nothing to draw. NaN leaves a gap.
    std::vector<double> time_s;
    std::vector<double> true_force_n;
    std::vector<double> estimate_n;
    std::vector<double> sigma_n;
    std::vector<double> rate_hz;  // mean of the neurons
    std::vector<double> gain;
    std::vector<double> emg;      // of the closing electrode, 1 at the strongest contraction
    std::vector<double> command;  // of the motor, −1 to 1

    std::vector<Level> levels;  // forces not to be passed
    std::vector<Event> events;
    std::optional<SpikeDensity> density;  // instead of events, where there are too many
    std::vector<Patch> patches;
    std::vector<Part> parts;
};

// Writes <stem>.svg and <stem>.png.
Drawing draw(const GraspPicture& picture, const std::filesystem::path& stem);

}  // namespace afferent
