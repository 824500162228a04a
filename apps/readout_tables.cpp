#include "afferent/apps/readout_tables.hpp"

#include <algorithm>

namespace afferent {

ReadoutTables::ReadoutTables(const Plan& plan) : plan_(plan) {
    if (!plan.controller) return;
    const Readouts::Parameters& readouts = plan.controller->readouts.parameters;
    for (const Readouts::Contact& contact : readouts.contacts) contacts_of_.push_back({contact.patch});
    for (const EdgeReadout::Parameters& edge : readouts.edges) touches_of_.push_back({edge.patch});
}

void ReadoutTables::open(const std::filesystem::path& folder, FullPipe full_pipe) {
    using Columns = std::initializer_list<std::string_view>;
    if (!contacts_of_.empty())
        contact_.emplace(folder / "contact.csv",
                         Columns{"time_s", "patch", "afferents", "force_n", "force_sigma_n", "x_mm",
                                 "x_sigma_mm", "y_mm", "y_sigma_mm", "area_mm2", "area_sigma_mm2"},
                         full_pipe);
    if (!touches_of_.empty())
        touches_.emplace(
            folder / "touches.csv",
            Columns{"time_s", "patch", "told_s", "afferents", "orientation_deg", "orientation_sigma_deg",
                    "direction_deg", "speed_mm_per_s", "speed_sigma_mm_per_s"},
            full_pipe);
}

ReadoutTables::OfPatch& ReadoutTables::of(std::vector<OfPatch>& patches, std::uint32_t patch) const {
    return *std::find_if(patches.begin(), patches.end(),
                         [&](const OfPatch& each) { return each.patch == patch; });
}

void ReadoutTables::step(const ControllerStep& step) {
    for (const PatchContact& contact : step.contacts) {
        double& largest_n = of(contacts_of_, contact.patch).largest_force_n;
        largest_n = std::max(largest_n, contact.estimate.force_n);
        if (contact_) write(contact, step.time);
    }
    for (const EdgeTouch& touch : step.touches) {
        OfPatch& patch = of(touches_of_, touch.patch);
        ++patch.touches;
        patch.last = touch;
        if (touches_) write(touch);
    }
}

void ReadoutTables::write(const PatchContact& contact, TimePoint time) {
    const ContactEstimate& estimate = contact.estimate;
    contact_->cell(time);
    contact_->text(plan_.patches[contact.patch].name);
    contact_->cell(std::uint64_t{estimate.afferents});
    contact_->cell(estimate.force_n);
    contact_->cell(estimate.force_sigma_n);
    for (const double place : {estimate.x_mm, estimate.x_sigma_mm, estimate.y_mm, estimate.y_sigma_mm}) {
        if (estimate.afferents > 0)
            contact_->cell(place);
        else
            contact_->no_value();
    }
    contact_->cell(estimate.area_mm2);
    contact_->cell(estimate.area_sigma_mm2);
    contact_->end_row();
}

void ReadoutTables::write(const EdgeTouch& touch) {
    touches_->cell(touch.begin);
    touches_->text(plan_.patches[touch.patch].name);
    touches_->cell(touch.told);
    touches_->cell(std::uint64_t{touch.afferents});
    touches_->cell(touch.edge.orientation_deg);
    touches_->cell(touch.edge.sigma_deg);
    for (const double of_slide :
         {touch.edge.direction_deg, touch.edge.speed_mm_per_s, touch.edge.speed_sigma_mm_per_s}) {
        if (touch.edge.slides)
            touches_->cell(of_slide);
        else
            touches_->no_value();
    }
    touches_->end_row();
}

void ReadoutTables::add_to(Summary& summary) const {
    for (const OfPatch& each : contacts_of_)
        summary["largest_contact_force_n"][plan_.patches[each.patch].name] = each.largest_force_n;
    for (const OfPatch& each : touches_of_) {
        Summary& touches = summary["touches"][plan_.patches[each.patch].name];
        touches["told"] = each.touches;
        if (!each.last) continue;
        touches["last_orientation_deg"] = each.last->edge.orientation_deg;
        touches["last_orientation_sigma_deg"] = each.last->edge.sigma_deg;
    }
}

}  // namespace afferent
