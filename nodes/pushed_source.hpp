// A live source: a program pushes the scans of its own sensors as they come.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/nodes/sample_source.hpp"

namespace afferent {

// A scan waits until the coprocessor takes it at its time; later ones can be pushed meanwhile. Allocates
// nothing after the first round. All calls come from one thread.
class PushedSource final : public SampleSource {
  public:
    // At most `capacity` scans wait: when there are more, the oldest is dropped and counted.
    explicit PushedSource(const Plan& plan, std::size_t capacity = 1024);

    // The forces of all elements of one patch at one time, in newtons. The time is not before that of the
    // last scan. An element whose force is not finite keeps the force that it had. An error says what is
    // wrong with the scan, and changes nothing.
    Result<void> push(const Scan& scan);
    std::uint64_t dropped() const noexcept { return dropped_; }

    std::optional<Due> next() override;
    std::optional<Scan> take(double hand_force_n) override;

  private:
    struct Waiting {
        Due due;
        std::vector<double> forces_n;
    };

    std::vector<Waiting> waiting_;  // a ring
    std::size_t first_ = 0;
    std::size_t count_ = 0;
    TimePoint last_ = scene_start;
    std::vector<std::vector<double>> held_n_;  // what each element was last told, by patch
    std::uint64_t dropped_ = 0;
};

}  // namespace afferent
