// The spiking coprocessor of a scene: samples in, address events out. Included by programs that emulate a
// spiking coprocessor.
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

// Needs no file and no link, and for small scenes no thread. Allocates only when a window holds more scans or
// events than any before it.
//
//     Coprocessor coprocessor(Scene::from_file("grasp.txtpb"));
//     coprocessor.push({time, 0, forces_n});
//     for (const Event& event : coprocessor.advance(time + 5ms)) ...
class Coprocessor {
  public:
    // Throws SceneError if the scene is invalid.
    explicit Coprocessor(const Scene& scene);
    explicit Coprocessor(const Plan& plan);
    ~Coprocessor();
    Coprocessor(Coprocessor&&) noexcept;
    Coprocessor& operator=(Coprocessor&&) noexcept;

    // Takes the forces of neighbouring elements, in N. Elements are numbered in the order of the patches that
    // have them. Each force is held until the element's next sample. Scans arrive in order of time and are
    // copied. A scan before now() acts at once and is counted as late. Non-finite forces and elements that
    // the scene does not have are skipped and counted.
    void push(const Scan& scan);

    // All events after now() up to and including `until`, sorted; valid until the next call. Throws
    // SpikeStormError if an afferent fires more often within a window than runtime.spikes_per_window.
    std::span<const Event> advance(TimePoint until);

    TimePoint now() const noexcept;
    std::uint64_t late_scans() const noexcept;
    std::uint64_t refused_samples() const noexcept;
    // The number of samples that have not acted yet.
    std::size_t waiting_samples() const noexcept;
    std::size_t threads() const noexcept;
    std::size_t shards() const noexcept;
    // Whether shards choose their form at run time; how many are dense at present; how many changes of form
    // there have been.
    bool changes_forms() const noexcept;
    std::size_t dense_shards() const noexcept;
    std::uint64_t form_changes() const noexcept;
    // Memory of all neurons, encoders and queues, in bytes.
    std::size_t bytes() const noexcept;

    // Returns to the beginning of the scene.
    void reset();

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace afferent
