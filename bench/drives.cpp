#include "bench/drives.hpp"

#include "afferent/encoders/field_encoder.hpp"
#include "afferent/nodes/run.hpp"

namespace afferent {
namespace {

// The drives of one patch, computed as its shard does.
template <Encoder E>
class PatchDrives {
  public:
    PatchDrives(const PatchPlan& patch, const E& encoder, std::vector<NeuronDrive>& drives)
        : first_(patch.first),
          encoder_(encoder, patch.fields, patch.first_element, 0, patch.afferents()),
          drives_(drives) {
        encoder_.reset([&](std::uint32_t i, double drive_mv) {
            drives_[first_ + i] = {patch.neuron_of(i), {{scene_start, drive_mv}}};
        });
    }

    void take(const Scan& scan) {
        encoder_.take({&scan, 1}, [&](std::size_t i, double drive_mv) {
            drives_[first_ + i].steps.push_back({scan.time, drive_mv});
        });
    }

  private:
    Address first_;
    FieldEncoder<E> encoder_;
    std::vector<NeuronDrive>& drives_;
};

template <class Encoders>
struct DrivesOf;
template <Encoder... E>
struct DrivesOf<std::variant<E...>> {
    using Type = std::variant<PatchDrives<E>...>;
};

}  // namespace

Result<std::vector<NeuronDrive>> record_drives(const Plan& plan) {
    std::vector<NeuronDrive> drives(plan.addresses);
    std::vector<DrivesOf<AnyEncoder>::Type> patches;
    for (const PatchPlan& patch : plan.patches) {
        visit_encoder(patch.encoder, [&]<class E>(const E& encoder) {
            patches.emplace_back(std::in_place_type<PatchDrives<E>>, patch, encoder, drives);
        });
    }
    Observer output;
    output.scan = [&](const Scan& scan) {
        for (auto& patch : patches) std::visit([&](auto& of_patch) { of_patch.take(scan); }, patch);
    };
    auto run = Run::open(plan, std::move(output));
    if (!run) return run.error();
    while (!run.value()->done())
        if (const Result<void> stepped = run.value()->do_next(); !stepped) return stepped.error();
    return drives;
}

}  // namespace afferent
