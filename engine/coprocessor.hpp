// The spiking coprocessor of a scene: samples in, address events out. To be included by programs that emulate
// one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct Plan;

// Needs no file, no link and, for small scenes, no thread. After construction it allocates nothing as long as
// scans and events stay below what a window has held before.
//
//     Coprocessor coprocessor(Scene::from_file("grasp.txtpb"));
//     coprocessor.push({time, 0, forces_n});
//     for (const Event& event : coprocessor.advance(time + 5ms)) ...
class Coprocessor {
  public:
    // Throws SceneError where the scene is wrong.
    explicit Coprocessor(const Scene& scene);
    explicit Coprocessor(const Plan& plan);
    ~Coprocessor();
    Coprocessor(Coprocessor&&) noexcept;
    Coprocessor& operator=(Coprocessor&&) noexcept;

    // Samples in N of neighbouring elements, numbered in the order of the patches that have them. Each holds
    // until the element's next sample. The scan is copied. Scans come in the order of time. A scan that lies
    // before now() is late: it acts at once, and is counted. Elements that the scene does not have, and
    // forces that are not finite, are passed over and counted.
    void push(const Scan& scan);

    // All events after now() up to and including `until`, sorted; valid until the next call. Throws
    // SpikeStormError where an element fires more often in a window than runtime.spikes_per_window allows.
    std::span<const Event> advance(TimePoint until);

    TimePoint now() const noexcept;
    std::uint64_t late_scans() const noexcept;
    std::uint64_t refused_samples() const noexcept;
    // The samples of scans that have not acted yet.
    std::size_t waiting_samples() const noexcept;
    std::size_t threads() const noexcept;
    std::size_t shards() const noexcept;
    // Whether shards choose their form; how many are swept at each scan; how often one has changed its form.
    bool changes_forms() const noexcept;
    std::size_t dense_shards() const noexcept;
    std::uint64_t form_changes() const noexcept;
    // The memory of all neurons with their encoders and queues.
    std::size_t bytes() const noexcept;

    // Back to the beginning of the scene.
    void reset();

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace afferent
