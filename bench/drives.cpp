#include "bench/drives.hpp"

#include "afferent/nodes/run.hpp"

namespace afferent {
namespace {

// The drives of one patch, computed as its shard does.
template <Encoder E>
class PatchDrives {
  public:
    PatchDrives(const Patch& patch, E encoder, Address reads, std::vector<NeuronDrive>& drives)
        : patch_(patch),
          encoder_(std::move(encoder)),
          reads_(reads),
          states_(patch.elements),
          drives_(drives) {
        for (std::uint32_t i = 0; i < patch.elements; ++i) {
            typename E::State untouched;
            drives_[patch.first + i] = {patch.neuron,
                                        {{scene_start, encoder_.drive_mv(untouched, scene_start, 0)}}};
        }
    }

    void take(const Scan& scan) {
        for (std::uint32_t i = 0; i < patch_.elements; ++i) {
            const std::size_t k =
                reads_ + i - scan.first;  // wraps around, and is beyond the end, where it is before it
            if (k >= scan.forces_n.size()) continue;
            const double drive = encoder_.drive_mv(states_[i], scan.time, scan.forces_n[k]);
            drives_[patch_.first + i].steps.push_back({scan.time, drive});
        }
    }

  private:
    const Patch& patch_;
    E encoder_;
    Address reads_;
    std::vector<typename E::State> states_;
    std::vector<NeuronDrive>& drives_;
};

}  // namespace

Result<std::vector<NeuronDrive>> record_drives(const Scene& scene) {
    std::vector<NeuronDrive> drives(scene.addresses());
    std::vector<std::variant<PatchDrives<Sustained>, PatchDrives<Transient>>> patches;
    for (const Patch& patch : scene.patches()) {
        const Address reads = scene.patches()[patch.reads].first;
        if (const auto* sustained = std::get_if<Sustained::Parameters>(&patch.encoder))
            patches.emplace_back(std::in_place_index<0>, patch, Sustained(*sustained), reads, drives);
        else
            patches.emplace_back(std::in_place_index<1>, patch,
                                 Transient(std::get<Transient::Parameters>(patch.encoder)), reads, drives);
    }
    Run::Output output;
    output.scan = [&](const Scan& scan) {
        for (auto& patch : patches) std::visit([&](auto& of_patch) { of_patch.take(scan); }, patch);
    };
    auto run = Run::open(scene, std::move(output));
    if (!run) return run.error();
    while (!run.value()->done())
        if (const Result<void> stepped = run.value()->do_next(); !stepped) return stepped.error();
    return drives;
}

}  // namespace afferent
