// What `bench scale` measures: a population of afferents that differ, of which a part is touched.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "afferent/encoders/sustained.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent::bench {

// Where the elements lie that are touched: one stretch of neighbours, or each by itself, evenly spread.
enum class Contact { block, scattered };

struct ScalePopulation {
    std::uint32_t elements = 9;
    double active_fraction = 1;  // of the elements is touched, to the nearest element
    Contact contact = Contact::block;
    bool adapts = true;
    bool differs = true;  // in thresholds and phases

    std::uint32_t active() const noexcept;

    friend bool operator==(const ScalePopulation&, const ScalePopulation&) = default;
};

// How it is carried out.
struct ScaleRun {
    ScalePopulation population;
    scene::Form form = scene::Form::automatic;
    std::uint32_t threads = 1;
};

inline constexpr Duration scale_frame = 5ms;
inline constexpr double scale_touched_n = 10;  // in the mean, on an element that is touched

std::string name(scene::Form form);
std::string name(Contact contact);

// The paper's neurons behind an encoder that lets a touched one fire at 30 Hz once it has adapted, and an
// untouched one rest. Without phases and thresholds of their own, and under one force, they would all fire
// at the same instants.
Scene scale_scene(const ScaleRun& run);
// The encoder that all elements have.
Sustained::Parameters scale_encoder(bool adapts);

// The forces of those elements that are touched, frame by frame. Elements that are not touched are not
// sampled.
class ScaleTouch {
  public:
    explicit ScaleTouch(const ScalePopulation& population);

    // The scans of one frame, as an embedding program pushes them.
    void push(std::uint64_t frame, Coprocessor& coprocessor) const;
    // The address of the i-th touched element, and its force.
    std::uint32_t element(std::uint32_t i) const noexcept { return i * stride_; }
    double force_n(std::uint64_t frame, std::uint32_t i) const noexcept { return forces_n(frame)[i]; }

  private:
    std::span<const double> forces_n(std::uint64_t frame) const noexcept;

    Contact contact_;
    std::uint32_t active_;
    std::uint32_t stride_ = 1;
    std::vector<double> noise_n_;
};

// A population in the course of time.
class RunningScale {
  public:
    RunningScale(const ScaleRun& run, const ScaleTouch& touch);

    // The next frame's events.
    std::span<const Event> frame();
    std::uint64_t frames() const noexcept { return frames_; }
    const Coprocessor& coprocessor() const noexcept { return coprocessor_; }

  private:
    const ScaleTouch& touch_;
    Coprocessor coprocessor_;
    std::uint64_t frames_ = 0;
};

}  // namespace afferent::bench
