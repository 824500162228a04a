// The spiking coprocessor of a scene: samples in, address events out. This is what a program embeds.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "afferent/engine/scan_routes.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/event_key.hpp"
#include "afferent/runtime/event_merge.hpp"
#include "afferent/runtime/number_sorter.hpp"
#include "afferent/runtime/parallel.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Needs no file, no link and, for small scenes, no thread. After construction it allocates nothing as long as
// scans and events stay below what a window has held before.
//
//     Coprocessor coprocessor(Scene::from_file("grasp.txtpb"));
//     coprocessor.push({time, 0, forces_n});
//     for (const Event& event : coprocessor.advance(time + 5ms)) ...
class Coprocessor {
  public:
    // Throws SceneError.
    explicit Coprocessor(const Scene& scene) : Coprocessor(make_plan(scene)) {}
    explicit Coprocessor(const Plan& plan);
    ~Coprocessor();
    Coprocessor(Coprocessor&&) noexcept;
    Coprocessor& operator=(Coprocessor&&) noexcept;

    // Samples in N of neighbouring elements, numbered in the order of the patches that have them; held until
    // their next. The scan is copied. Scans come in the order of time. One that lies before now() is late: it
    // acts at once, and is counted. Elements that the scene does not have, and forces that are not finite,
    // are passed over and counted.
    void push(const Scan& scan);

    // All events after now() up to and including `until`, sorted; valid until the next call. Throws
    // SpikeStormError.
    std::span<const Event> advance(TimePoint until);

    TimePoint now() const noexcept { return now_; }
    std::uint64_t late_scans() const noexcept { return late_scans_; }
    std::uint64_t refused_samples() const noexcept { return refused_samples_; }
    // The samples of scans that have not acted yet.
    std::size_t waiting_samples() const noexcept { return forces_n_.size(); }
    std::size_t threads() const noexcept { return workers_.threads(); }
    std::size_t shards() const noexcept { return parts_.size(); }
    // Whether shards choose their form; how many are swept at each scan; how often one has changed its form.
    bool changes_forms() const noexcept { return changes_forms_; }
    std::size_t dense_shards() const noexcept;
    std::uint64_t form_changes() const noexcept;
    // The memory of all neurons with their encoders and queues.
    std::size_t bytes() const noexcept;

    // Back to the beginning of the scene.
    void reset();

  private:
    struct Part {
        std::unique_ptr<Shard> shard;
        std::vector<Scan> scans;  // of the window, for this shard
        TimePoint next;           // of the shard
    };
    // Neighbouring parts that are computed one after the other, with their events of the window.
    struct Lot {
        std::size_t begin;
        std::size_t end;
        EventKeys events;
        NumberSorter sorter;
    };
    // A part of the window whose events are merged by themselves.
    struct Slice {
        EventMerge merge;
        std::size_t first_event;  // among those of the window
    };

    // A window that is not too long for EventKeys.
    void advance_window(TimePoint until);
    void route_scans(TimePoint until);
    void compute(Lot& lot, TimePoint until);
    void merge_events(TimePoint until);
    std::span<const EventKey> keys_in(const Lot& lot, std::size_t slice, TimePoint until) const;

    std::uint32_t elements_;
    bool changes_forms_;
    std::vector<Part> parts_;
    std::vector<Lot> lots_;
    std::vector<Slice> slices_;
    ScanRoutes routes_;
    Workers workers_;
    std::vector<Scan> scans_;
    std::vector<double> forces_n_;       // of scans_, one after the other
    std::vector<std::uint32_t> routed_;  // parts that have scans
    std::vector<Event> events_;
    TimePoint now_ = scene_start;
    std::uint64_t late_scans_ = 0;
    std::uint64_t refused_samples_ = 0;
};

}  // namespace afferent
