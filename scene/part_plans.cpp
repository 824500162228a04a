#include "afferent/scene/part_plans.hpp"

#include <algorithm>
#include <cctype>
#include <numeric>
#include <set>

#include "afferent/decoders/afferent_builder.hpp"

namespace afferent {
namespace {

// A name for columns, which other programs read as an identifier.
std::string column_name(const std::string& name) {
    std::string column = name;
    for (char& c : column)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    return column;
}

class PartPlanner {
  public:
    explicit PartPlanner(const Plan& plan) : plan_(plan) {}

    std::vector<PartPlan> plan() {
        const scene::Parts asked = plan_.scene.decoder.parts;
        for (std::size_t i = 0; i < plan_.patches.size(); ++i) {
            const PatchPlan& patch = plan_.patches[i];
            if (!patch.owns_elements || asked == scene::Parts::none) continue;
            const std::string name = unique(column_name(patch.name));
            if (asked == scene::Parts::patches) add(i, name, 0, patch.elements());
            for (std::uint32_t element = 0; asked == scene::Parts::elements && element < patch.elements();
                 ++element)
                add(i, name + "_" + std::to_string(element), element, 1);
        }
        return std::move(parts_);
    }

  private:
    std::string unique(std::string name) {
        while (!names_.insert(name).second) name += "_";
        return name;
    }

    // Adds a part of `count` elements of a patch, counted within it.
    void add(std::size_t owner, std::string name, std::uint32_t first, std::uint32_t count) {
        const PatchPlan& of = plan_.patches[owner];
        const std::span<const double> shares = std::span(of.share).subspan(first, count);
        const double share = std::accumulate(shares.begin(), shares.end(), 0.0);
        const auto within = [&](std::uint32_t element) {
            return element >= first && element < first + count;
        };
        // The force on an element of the patch for one newton of the part.
        const auto felt_by = [&](std::uint32_t element) {
            return share > 0 ? of.share[element] / share : within(element) ? 1.0 / count : 0.0;
        };

        PartPlan part{.name = std::move(name),
                      .patch = owner,
                      .first_element = of.first_element + first,
                      .elements = count,
                      .decoded = {.afferents = {.addresses = plan_.addresses}, .share = share}};
        DecodedAfferents& afferents = part.decoded.afferents;
        AfferentBuilder builder(afferents);
        afferents.uncertainty = plan_.scene.uncertainty;
        afferents.tick = plan_.packets ? plan_.timing.tick : Duration(1);
        afferents.hysteresis = of.sensor.hysteresis;
        for (std::uint32_t i = first; i < first + count; ++i)
            if (felt_by(i) > 0)
                afferents.largest_grip_n =
                    std::max(afferents.largest_grip_n, of.sensor.full_scale_n / felt_by(i));
        for (const PatchPlan& patch : plan_.patches) {
            if (patch.reads != owner || !is_read(plan_.scene, patch)) continue;
            afferents.delay = patch.delay();
            const auto read = [&](std::uint32_t afferent, double felt, double felt_most) {
                builder.add(patch.first + afferent, decoded_group(patch, afferent, felt, felt_most), felt);
            };
            afferents.scan = std::max(afferents.scan, patch.scan_interval);
            if (patch.fields.is_one_each()) {
                for (std::uint32_t i = first; i < first + count; ++i) read(i, felt_by(i), felt_by(i));
                continue;
            }
            for (std::uint32_t i = 0; i < patch.afferents(); ++i) {
                double felt = 0;
                double felt_most = 0;
                bool reads = false;
                for (const auto& [element, weight] : patch.fields.row(i)) {
                    felt += weight * felt_by(element);
                    felt_most = std::max(felt_most, felt_by(element));
                    reads = reads || within(element);
                }
                if (reads) read(i, felt, felt_most);
            }
        }
        if (!afferents.afferents.empty()) parts_.push_back(std::move(part));
    }

    const Plan& plan_;
    std::set<std::string> names_;
    std::vector<PartPlan> parts_;
};

}  // namespace

bool is_read(const Scene& scene, const PatchPlan& patch) {
    const std::vector<std::string>& names = scene.decoder.patch;
    if (names.empty()) return patch.proportional() || (patch.decodable() && is_filter(scene.decoder));
    return std::find(names.begin(), names.end(), patch.name) != names.end();
}

DecodedAfferents::Group decoded_group(const PatchPlan& patch, std::uint32_t afferent, double felt,
                                      double felt_most) {
    DecodedAfferents::Group group{patch.neuron_of(afferent), 0, patch.bias_mv()};
    (patch.sustained() ? group.drive_mv_per_n : group.drive_mv_s_per_n) = patch.gain() * felt;
    if (!(felt_most > 0)) return group;
    const double full_scale_n = patch.sensor.full_scale_n;
    group.full_scale_n = full_scale_n / felt_most;
    // Sensors tell the less the harder they are pressed.
    const Sensor sensor(patch.sensor);
    const double least_n = sensor.noise_n(0);
    group.noise_n = least_n / felt_most;
    group.noise_fraction = std::max(0.0, sensor.noise_n(full_scale_n) - least_n) / full_scale_n;
    return group;
}

std::vector<PartPlan> part_plans(const Plan& plan) { return PartPlanner(plan).plan(); }

PartDecoders make_part_decoders(const ControllerPlan& plan) {
    std::vector<PartDecoders::Part> parts;
    for (const PartPlan& part : plan.parts) parts.push_back(part.decoded);
    // The gain goes by the grip: which force of a part is coming nobody reads.
    DecoderParameters decoder = plan.decoder;
    if (auto* filter = std::get_if<FilterParameters>(&decoder)) filter->lead = Duration(0);
    return {decoder, parts};
}

}  // namespace afferent
