#include "afferent/scene/shorthands.hpp"

#include "afferent/io/files/plain_table.hpp"
#include "afferent/scene/scene.hpp"
#include "afferent/scene/scene_message.hpp"

namespace afferent {
namespace {

proto::Patch preset_of(const proto::Patch& patch) {
    proto::Patch filled;
    if (!patch.has_kind()) return filled;
    const scene::Patch of_kind = scene::preset(static_cast<scene::Kind>(patch.kind()));
    each_field(of_kind, Writer(filled));
    return filled;
}

// The patch with what it does not say itself taken from every_patch, and what neither says from their kind. A
// list of its own replaces the shared one.
proto::Patch filled_in(const proto::Patch& shared, const proto::Patch& own) {
    proto::Patch patch = preset_of(own.has_kind() ? own : shared);
    patch.MergeFrom(shared);
    if (own.spread().time_class_size()) patch.mutable_spread()->clear_time_class();
    // Either way of giving places replaces the other.
    if (own.afferents().place_size() || own.afferents().has_places()) {
        patch.mutable_afferents()->clear_place();
        patch.mutable_afferents()->clear_places();
    }
    if (own.share_size()) patch.clear_share();
    if (own.field_size()) patch.clear_field();
    if (own.sensor().calibration_size()) patch.mutable_sensor()->clear_calibration();
    if (own.sensor().dead_element_size()) patch.mutable_sensor()->clear_dead_element();
    if (own.sensor().stuck_element_size()) patch.mutable_sensor()->clear_stuck_element();
    // The patch whose elements it reads has the sensor and the outline.
    if (own.has_elements_of()) {
        patch.clear_sensor();
        patch.clear_outline();
    }
    patch.MergeFrom(own);
    patch.clear_kind();
    patch.clear_kinds();
    patch.clear_per_cm2();
    return patch;
}

// One patch for each of its kinds, or the patch itself.
std::vector<proto::Patch> one_of_each_kind(const proto::Patch& shared, const proto::Patch& own) {
    const auto& kinds = own.kinds_size() ? own.kinds() : shared.kinds();
    const auto& per_cm2 = own.per_cm2_size() ? own.per_cm2() : shared.per_cm2();
    if (kinds.empty() || own.has_kind()) return {own};
    std::vector<proto::Patch> patches;
    for (int i = 0; i < kinds.size(); ++i) {
        proto::Patch patch = own;
        const auto kind = static_cast<proto::Kind>(kinds[i]);
        patch.set_kind(kind);
        patch.set_name(own.name() + (own.name().empty() ? "" : " ") +
                       scene::name(static_cast<scene::Kind>(kind)));
        if (i < per_cm2.size()) patch.mutable_afferents()->set_per_cm2(per_cm2[i]);
        if (i > 0 && !own.has_elements_of()) {
            patch.clear_elements();
            patch.clear_share();
            patch.clear_outline();
            patch.clear_sensor();
            patch.set_elements_of(patches.front().name());
        }
        patches.push_back(std::move(patch));
    }
    return patches;
}

}  // namespace

Written resolve_shorthands(proto::Scene& scene) {
    if (scene.has_every_patch() && scene.patch_size() == 0)
        for (const scene::Patch& patch : Scene().patches) scene.add_patch()->set_name(patch.name);
    proto::Scene resolved;
    Written written;
    for (int i = 0; i < scene.patch_size(); ++i)
        for (const proto::Patch& patch : one_of_each_kind(scene.every_patch(), scene.patch(i))) {
            *resolved.add_patch() = filled_in(scene.every_patch(), patch);
            written.push_back(static_cast<std::size_t>(i));
        }
    scene.mutable_patch()->Swap(resolved.mutable_patch());
    scene.clear_every_patch();
    if (scene.decoder().has_window_ms()) {
        const double window_ms = scene.decoder().window_ms();
        if (scene.decoder().kind_case() == proto::Decoder::KIND_NOT_SET)
            scene.mutable_decoder()->mutable_sliding_window()->set_window_ms(window_ms);
    }
    return written;
}

std::optional<std::pair<std::string, std::string>> wrong_kinds(const proto::Patch& shared,
                                                               const proto::Patch& own) {
    const int kinds = own.kinds_size() ? own.kinds_size() : shared.kinds_size();
    const int densities = own.per_cm2_size() ? own.per_cm2_size() : shared.per_cm2_size();
    if (own.kinds_size() && own.has_kind()) return std::pair("kinds", "a patch has either a kind or kinds");
    if (densities && densities != kinds && !own.has_kind())
        return std::pair("per_cm2", "per_cm2 must be given once for each of the " + std::to_string(kinds) +
                                        " kinds, is given " + std::to_string(densities) + " times");
    return std::nullopt;
}

bool has_stimuli(const proto::Source& source) {
    return source.has_skin() || source.edge_size() + source.indenter_size() + source.grating_size() +
                                        source.dots_size() + source.texture_size() + source.grasp_size() >
                                    0;
}

std::optional<std::string> read_places(proto::Patch& patch, const std::filesystem::path& folder) {
    if (!patch.afferents().has_places()) return std::nullopt;
    proto::Afferents& afferents = *patch.mutable_afferents();
    if (afferents.place_size()) return "afferents: either place or places";
    const auto table = read_plain_table(folder / afferents.places(), {"x_mm", "y_mm"});
    if (const auto* error = std::get_if<TableError>(&table)) return error->message();
    const auto& values = std::get<std::vector<double>>(table);
    for (std::size_t i = 0; i < values.size(); i += 2) {
        proto::Point& place = *afferents.add_place();
        place.set_x_mm(values[i]);
        place.set_y_mm(values[i + 1]);
    }
    afferents.clear_places();
    return std::nullopt;
}

}  // namespace afferent
