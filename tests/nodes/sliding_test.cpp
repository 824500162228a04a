// What slides over the skin is smooth: afferents do not tell of the grid of elements that they read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/nodes/whole_run.hpp"

namespace afferent {
namespace {

// A stimulus that begins to press, slides and ends far from the borders of the skin, where it ends for all
// afferents at once.
struct Slide {
    const char* name;
    const char* stimulus;
    double speed_mm_per_s;
    double duration_s;
};
constexpr Slide slides[] = {
    {"edge",
     "edge { speed_mm_per_s: 20 begin_mm: -10 peak_kpa: 60 press { rise_s: 0.2 hold_s: 0.6 fall_s: 0.2 } }",
     20, 1.05},
    {"edge at 30 degrees",
     "edge { direction_deg: 30 speed_mm_per_s: 20 begin_mm: -10 peak_kpa: 60 press { rise_s: 0.2 hold_s: 0.6 "
     "fall_s: 0.2 } }",
     20, 1.05},
    {"fast edge", "edge { speed_mm_per_s: 50 begin_mm: -10 press { rise_s: 0.1 hold_s: 0.2 fall_s: 0.1 } }",
     50, 0.45},
    {"sphere",
     "indenter { x_mm: -10 speed_mm_per_s: 40 radius_mm: 2 force_n: 0.5 press { rise_s: 0.1 hold_s: 0.3 "
     "fall_s: "
     "0.1 } }",
     40, 0.55},
};

using SpikesByKind = std::map<std::string, std::vector<double>>;

SpikesByKind spikes_of(const Slide& slide, double pitch_mm) {
    const Plan plan = make_plan(Scene::from_text(
        "duration_s: " + std::to_string(slide.duration_s) +
        " patch { name: 'SA1' kind: SA1 outline { rectangle { width_mm: 36 height_mm: 12 } pitch_mm: " +
        std::to_string(pitch_mm) +
        " } sensor { rate_hz: 1000 full_scale_n: 0.1 adc_bits: 24 } } patch { name: 'RA' kind: RA "
        "elements_of: "
        "'SA1' } patch { name: 'PC' kind: PC elements_of: 'SA1' } source { " +
        slide.stimulus + " } record { force: false picture: false }"));
    SpikesByKind spikes;
    whole_run(plan, {.events = [&](std::span<const Event> events) {
                  for (const Event& event : events)
                      for (const PatchPlan& patch : plan.patches)
                          if (event.address >= patch.first && event.address < patch.first + patch.afferents())
                              spikes[patch.name].push_back(seconds(event.time));
              }});
    return spikes;
}

// Of a train of spikes; 1 on average, if they are independent.
double power(const std::vector<double>& spikes_s, double hz) {
    double cosines = 0;
    double sines = 0;
    for (const double time_s : spikes_s) {
        cosines += std::cos(2 * std::numbers::pi * hz * time_s);
        sines += std::sin(2 * std::numbers::pi * hz * time_s);
    }
    return (cosines * cosines + sines * sines) / static_cast<double>(spikes_s.size());
}

// The power where elements pass by, and the largest in the 15 independent frequencies around it.
struct Line {
    double power;
    double around;
};
Line line_at(const std::vector<double>& spikes_s, double hz, double duration_s) {
    Line line{0, 0};
    for (int i = -30; i <= 30; ++i) {
        const double shift = i / 4.0;  // in units of the resolution
        double& largest = std::abs(shift) < 0.5 ? line.power : line.around;
        if (std::abs(shift) >= 0.5 && std::abs(shift) < 1.5) continue;  // the line's own flanks
        largest = std::max(largest, power(spikes_s, hz + shift / duration_s));
    }
    return line;
}

TEST(WhatSlides, IsSmoothWhateverThePitch) {
    for (const Slide& slide : slides) {
        std::map<double, SpikesByKind> by_pitch;
        for (const double pitch_mm : {1.0, 0.5, 0.25}) by_pitch[pitch_mm] = spikes_of(slide, pitch_mm);
        const auto& finest = by_pitch.at(0.25);
        for (const auto& [pitch_mm, spikes] : by_pitch) {
            const auto rate = [&](const std::string& kind, const SpikesByKind& of) {
                return static_cast<double>(of.at(kind).size());
            };
            EXPECT_NEAR(rate("PC", spikes) / rate("PC", finest), 1, 0.05) << slide.name << ' ' << pitch_mm;
            // Fields of 0.5 mm are as wide as elements of 0.5 mm allow, and wider on coarser ones.
            if (pitch_mm <= 0.5) {
                EXPECT_NEAR(rate("RA", spikes) / rate("RA", finest), 1, 0.05)
                    << slide.name << ' ' << pitch_mm;
            }
            for (const char* kind : {"RA", "PC"}) {
                const Line line = line_at(spikes.at(kind), slide.speed_mm_per_s / pitch_mm, slide.duration_s);
                // Of independent spikes, too, one in twenty lines is above 3.
                EXPECT_LT(line.power, std::max(line.around, 3.0))
                    << slide.name << ' ' << pitch_mm << ' ' << kind;
                std::printf("%-20s %.2f mm  %s %5zu spikes, line %.1f, around it up to %.1f\n", slide.name,
                            pitch_mm, kind, spikes.at(kind).size(), line.power, line.around);
            }
        }
    }
}

}  // namespace
}  // namespace afferent
