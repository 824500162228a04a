// Samples of skin that an edge slides over.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "afferent/hand/edge_contact.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/runtime/event_queue.hpp"

namespace afferent {

// An element is sampled while the edge touches it and until the encoders that read it have settled; before
// and after that it costs nothing. The first scan, and every scan of noisy sensors, is of all elements.
// Several scans, each of neighbouring elements, may have the same time.
//
// A cell counts as a strip across the edge's direction, as wide and long as the pitch: exact for an edge
// along rows or columns, and otherwise right in its sum over neighbouring cells.
class EdgeSource final : public SampleSource {
  public:
    // The scene's source is an edge.
    explicit EdgeSource(const Plan& plan);

    std::optional<Due> next() override;
    std::optional<Scan> take(double hand_force_n) override;
    Error refusal() const override;
    std::optional<double> true_force_n(TimePoint) const override { return std::nullopt; }

  private:
    // The state of one patch that has elements of its own.
    struct Skin {
        std::vector<std::pair<double, std::uint32_t>>
            along;  // how far along the direction each element lies, sorted
        std::vector<double> forces_n;
        std::vector<std::uint64_t> active_until;  // the last sample of each element; 0: it has been left
        std::vector<std::uint32_t> active;        // in order, once sampled
        std::uint64_t settling = 0;               // samples
        std::uint64_t sample = 0;                 // that is due
    };

    void press(Skin& skin, double pitch_mm, TimePoint time);
    void schedule(std::size_t patch);

    scene::Edge edge_;
    EdgeContact contact_;
    std::vector<Skin> skins_;  // by patch
    EventQueue queue_;
    // Progress within the scan that is due: whether its forces have been found, and how many of its active
    // elements have been taken.
    bool pressed_ = false;
    std::size_t taken_ = 0;
};

}  // namespace afferent
