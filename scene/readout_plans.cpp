#include "afferent/scene/readout_plans.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "afferent/decoders/interval_drive.hpp"
#include "afferent/hand/aperture.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/part_plans.hpp"

namespace afferent {
namespace {

// A place and its spread take three.
constexpr std::uint32_t fewest_for_contact = 3;
// An estimate takes 0.2 to 2 ms for 75 of them (contact.hpp).
constexpr std::uint32_t most_for_contact = 1024;
// Where an afferent fires without a force, the pressure that counts as so many units is full scale.
constexpr double units_of_full_scale = 20;

// The receptive fields of a patch on its elements, which lie in a grid.
class SkinFields {
  public:
    SkinFields(const Plan& plan, const PatchPlan& patch)
        : patch_(patch),
          grid_(*plan.patches[patch.reads].grid),
          element_variance_mm2_(cell_mm2() *
                                (touch_of(plan.scene.source) ? Aperture::sd * Aperture::sd : 1.0 / 12)) {}

    // Where it is narrower.
    double width_mm() const {
        double x[2]{grid_.place(0).x_mm, grid_.place(0).x_mm};
        double y[2]{grid_.place(0).y_mm, grid_.place(0).y_mm};
        for (std::uint32_t i = 0; i < grid_.elements(); ++i) {
            const Position& place = grid_.place(i);
            x[0] = std::min(x[0], place.x_mm);
            x[1] = std::max(x[1], place.x_mm);
            y[0] = std::min(y[0], place.y_mm);
            y[1] = std::max(y[1], place.y_mm);
        }
        return std::min(x[1] - x[0], y[1] - y[0]) + grid_.pitch_mm();
    }
    double cell_mm2() const { return grid_.pitch_mm() * grid_.pitch_mm(); }
    SkinField element(std::uint32_t element) const {
        const Position& place = grid_.place(element);
        return {place.x_mm, place.y_mm, element_variance_mm2_};
    }
    SkinField field(std::uint32_t afferent) const {
        double sum = 0, x = 0, y = 0, squares = 0;
        each_weight(afferent, [&](std::uint32_t at, double weight) {
            const Position& place = grid_.place(at);
            sum += weight;
            x += weight * place.x_mm;
            y += weight * place.y_mm;
            squares += weight * (place.x_mm * place.x_mm + place.y_mm * place.y_mm);
        });
        x /= sum;
        y /= sum;
        return {x, y, std::max(0.0, (squares / sum - x * x - y * y) / 2) + element_variance_mm2_};
    }
    // What the afferent reads, in N, of a pressure of 1 N/mm² that is the same everywhere.
    double weight_mm2(std::uint32_t afferent) const {
        double sum = 0;
        each_weight(afferent, [&](std::uint32_t, double weight) { sum += weight; });
        return sum * cell_mm2();
    }
    // What reaches the encoder of one that is at rest when its neuron begins to fire: the mean pressure under
    // its field, or its rate of change, times what is the same for all of the patch.
    double threshold(std::uint32_t afferent) const {
        return (rheobase_mv(patch_.neuron_of(afferent)) - patch_.bias_mv()) /
               (patch_.gain() * weight_mm2(afferent));
    }

  private:
    void each_weight(std::uint32_t afferent, const std::function<void(std::uint32_t, double)>& take) const {
        if (patch_.fields.is_one_each()) return take(afferent, 1);
        for (const auto& [element, weight] : patch_.fields.row(afferent)) take(element, weight);
    }

    const PatchPlan& patch_;
    const ElementGrid& grid_;
    double element_variance_mm2_;  // of an aperture under stimuli; otherwise of a square
};

// How an encoder rectifies the slope of the force. Null if it encodes something else, or has a threshold.
const Rectification* rectification_of_slope(const EncoderParameters& encoder) {
    const Rectification* found = nullptr;
    if (const auto* plain = std::get_if<Transient::Parameters>(&encoder)) found = &plain->rectification;
    if (const auto* band = std::get_if<BandTransient::Parameters>(&encoder)) found = &band->rectification;
    return found && found->threshold == 0 ? found : nullptr;
}

// The transient afferents on a patch's elements that respond to a falling pressure too, unless decoder.patch
// names other patches only.
std::vector<CommonChange::Transient> transients_beside(const Plan& plan, const PatchPlan& patch) {
    std::vector<CommonChange::Transient> all;
    const std::vector<std::string>& names = plan.scene.decoder.patch;
    for (const PatchPlan& other : plan.patches) {
        const Rectification* const rectification = rectification_of_slope(other.encoder);
        if (!rectification || !(rectification->negative_ratio > 0) || other.reads != patch.reads) continue;
        if (!names.empty() && std::ranges::find(names, other.name) == names.end()) continue;
        const SkinFields skin(plan, other);
        for (std::uint32_t i = 0; i < other.afferents(); ++i) {
            const double tau_m_s = 1e-3 * lif_of(other.neuron_of(i)).tau_m_ms;
            const double rise = skin.threshold(i) * tau_m_s;
            if (rise > 0)
                all.push_back(
                    {other.first + i, skin.field(i), rise / rectification->negative_ratio, rise, tau_m_s});
        }
    }
    return all;
}

ReadoutParameters contact_of(const Plan& plan, std::size_t index, const SkinFields& skin) {
    const PatchPlan& patch = plan.patches[index];
    ContactReadout::Parameters contact{.addresses = plan.addresses,
                                       .patch = {static_cast<std::uint32_t>(index)},
                                       .interval = from_milliseconds(plan.scene.decoder.contact->interval_ms),
                                       .element_mm2 = skin.cell_mm2(),
                                       .scan = patch.scan_interval,
                                       .tick = plan.packets ? plan.timing.tick : Duration(1),
                                       .hysteresis = patch.sensor.hysteresis};
    const double full_scale_n_per_mm2 = patch.sensor.full_scale_n / skin.cell_mm2();
    for (std::uint32_t i = 0; i < patch.afferents(); ++i) {
        const double threshold_n_per_mm2 = skin.threshold(i);
        const double unit_n_per_mm2 = threshold_n_per_mm2 > 0
                                          ? threshold_n_per_mm2 / ContactReadout::units_at_threshold
                                          : full_scale_n_per_mm2 / units_of_full_scale;
        const double felt_n = skin.weight_mm2(i) * unit_n_per_mm2;
        contact.afferents.push_back(
            {.address = patch.first + i,
             .group = decoded_group(patch, i, felt_n, skin.cell_mm2() * unit_n_per_mm2),
             .unit_n_per_mm2 = unit_n_per_mm2,
             .field = skin.field(i)});
    }
    contact.transients = transients_beside(plan, patch);
    for (std::uint32_t i = 0; i < patch.elements(); ++i) contact.elements.push_back(skin.element(i));
    return contact;
}

ReadoutParameters edge_of(const Plan& plan, std::size_t index, const SkinFields& skin) {
    const PatchPlan& patch = plan.patches[index];
    EdgeReadout::Parameters edge{.addresses = plan.addresses,
                                 .patch = {static_cast<std::uint32_t>(index)},
                                 .settle = from_milliseconds(plan.scene.decoder.edge->settle_ms)};
    for (std::uint32_t i = 0; i < patch.afferents(); ++i)
        edge.afferents.push_back({patch.first + i, {skin.field(i), skin.threshold(i)}});
    return edge;
}

ReadoutParameters texture_of(const Plan& plan, std::size_t index, const SkinFields& skin) {
    const PatchPlan& patch = plan.patches[index];
    TextureReadout::Parameters texture{.addresses = plan.addresses,
                                       .patch = {static_cast<std::uint32_t>(index)},
                                       .window = from_milliseconds(plan.scene.decoder.texture->window_ms)};
    for (std::uint32_t i = 0; i < patch.afferents(); ++i)
        texture.afferents.push_back({patch.first + i, skin.field(i)});
    return texture;
}

std::string afferents(std::uint32_t count) {
    return std::to_string(count) + (count == 1 ? " afferent" : " afferents");
}

// Why a patch cannot have a read-out; empty if it can.
std::string no_contact(const Plan& plan, const PatchPlan& patch) {
    if (!plan.patches[patch.reads].grid) return "no positions: outline is not given";
    if (!patch.decodable())
        return "no decoder inverts its encoder: a corner frequency, a dynamic term, slow adaptation, a "
               "half-wave or a "
               "threshold";
    if (!patch.sustained()) return "its encoder is not sustained: it tells no pressure that is held";
    if (!is_read(plan.scene, patch)) return "decoder.patch does not name it";
    if (patch.afferents() < fewest_for_contact)
        return "too few: " + afferents(patch.afferents()) + ", at least " +
               std::to_string(fewest_for_contact);
    if (patch.afferents() > most_for_contact)
        return "too many: " + afferents(patch.afferents()) + ", at most " + std::to_string(most_for_contact);
    const SkinFields skin(plan, patch);
    for (std::uint32_t i = 0; i < patch.afferents(); ++i)
        if (!(skin.threshold(i) * skin.cell_mm2() < patch.sensor.full_scale_n))
            return "an afferent is silent up to its sensors' full scale";
    return "";
}

// Why a patch cannot have a read-out that needs so many afferents with narrow fields at places of their own.
std::string no_places(const Plan& plan, const PatchPlan& patch, std::size_t fewest) {
    if (!plan.patches[patch.reads].grid) return "no positions: outline is not given";
    if (patch.afferents() < fewest)
        return "too few: " + afferents(patch.afferents()) + ", at least " + std::to_string(fewest);
    const SkinFields skin(plan, patch);
    // An afferent whose field covers the skin does not tell where on it the edge is.
    double field_mm = 0;
    for (std::uint32_t i = 0; i < patch.afferents(); ++i)
        field_mm += std::sqrt(skin.field(i).variance_mm2) / patch.afferents();
    if (5 * field_mm > skin.width_mm()) return "its fields are as wide as the skin";
    return "";
}

std::string no_texture(const Plan& plan, const PatchPlan& patch) {
    if (patch.afferents() > TextureReadout::most)
        return "too many: " + afferents(patch.afferents()) + ", at most " +
               std::to_string(TextureReadout::most);
    return no_places(plan, patch, TextureReadout::fewest);
}

std::string no_edge(const Plan& plan, const PatchPlan& patch) {
    const std::string places = no_places(plan, patch, EdgeFit::fewest);
    if (!places.empty()) return places;
    const SkinFields skin(plan, patch);
    for (std::uint32_t i = 0; i < patch.afferents(); ++i)
        if (!(skin.threshold(i) > 0)) return "an afferent fires untouched: its spikes begin no touch";
    return "";
}

// A kind of read-out: one line in the table below.
struct ReadoutKind {
    const char* what;   // in the plan's items
    const char* field;  // of scene::Decoder
    const char* how;    // it is built, before its number of afferents
    bool (*is_asked)(const scene::Decoder&);
    // Why a patch cannot have it; empty if it can.
    std::string (*refusal)(const Plan&, const PatchPlan&);
    ReadoutParameters (*made)(const Plan&, std::size_t patch, const SkinFields&);
};

constexpr ReadoutKind readout_kinds[]{
    {"contact", "contact", "the pressures of ",
     [](const auto& decoder) { return decoder.contact.has_value(); }, no_contact, contact_of},
    {"edges", "edge", "first spikes of ", [](const auto& decoder) { return decoder.edge.has_value(); },
     no_edge, edge_of},
    {"texture", "texture", "waves over ", [](const auto& decoder) { return decoder.texture.has_value(); },
     no_texture, texture_of}};

std::string transients_of(const ReadoutParameters& parameters) {
    const auto* const contact = std::get_if<ContactReadout::Parameters>(&parameters);
    if (!contact || contact->transients.empty()) return "";
    return ", and how they fall by " + std::to_string(contact->transients.size()) + " transient ones";
}

std::string name_of(const ReadoutKind& kind) { return std::string("read-out of ") + kind.what; }

std::string field_of(const ReadoutKind& kind) { return std::string("decoder.") + kind.field; }

void require_one(const ReadoutKind& kind, const std::vector<PlanItem>& items) {
    std::string reasons;
    for (const PlanItem& item : items) {
        if (item.built) return;
        if (reasons.find(item.reason) == std::string::npos)
            reasons += (reasons.empty() ? "" : "; ") + item.reason;
    }
    throw ParameterError(kind.field, "for a patch that can have it", "for none: " + reasons);
}

// The read-outs of that kind, as parameters and as items.
std::vector<PlanItem> add_kind(const Plan& plan, const ReadoutKind& kind,
                               std::vector<ReadoutParameters>& parameters) {
    std::vector<PlanItem> items;
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        const PatchPlan& patch = plan.patches[i];
        const std::string refusal = kind.refusal(plan, patch);
        std::string reason = refusal;
        if (refusal.empty()) {
            parameters.push_back(kind.made(plan, i, SkinFields(plan, patch)));
            reason = field_of(kind) + ": " + kind.how + afferents(patch.afferents()) +
                     transients_of(parameters.back());
        }
        items.push_back({name_of(kind) + ", \"" + patch.name + "\"", refusal.empty(), reason});
    }
    return items;
}

}  // namespace

bool asks_for_readouts(const scene::Decoder& decoder) {
    return std::ranges::any_of(readout_kinds,
                               [&](const ReadoutKind& kind) { return kind.is_asked(decoder); });
}

ReadoutPlans readout_plans(const Plan& plan) {
    ReadoutPlans plans;
    for (const ReadoutKind& kind : readout_kinds) {
        if (!kind.is_asked(plan.scene.decoder)) continue;
        const auto items = add_kind(plan, kind, plans.parameters);
        require_one(kind, items);
        plans.items.insert(plans.items.end(), items.begin(), items.end());
    }
    return plans;
}

void add_readout_items(const Plan& plan, PlanItems& items) {
    for (const ReadoutKind& kind : readout_kinds)
        if (!plan.controller || !kind.is_asked(plan.scene.decoder))
            items.add(name_of(kind), false, field_of(kind) + " is not given");
    if (plan.controller)
        for (const PlanItem& item : plan.controller->readouts.items)
            items.add(item.name, item.built, item.reason);
}

}  // namespace afferent
