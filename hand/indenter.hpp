// A probe that presses into the skin, holds, vibrates or slides.
#pragma once

#include <optional>

#include "afferent/hand/disc_contact.hpp"
#include "afferent/hand/stimulus.hpp"

namespace afferent {

class Indenter {
  public:
    using Parameters = IndenterParameters;
    Indenter(const Parameters& parameters, const ElasticSkin& skin, const Aperture& aperture)
        : parameters_(parameters),
          skin_(skin),
          heading_(Heading::of_degrees(parameters.direction_deg)),
          aperture_(aperture) {
        DiscContact::make_table(parameters.tip);
    }

    DiscContact at(TimePoint time) const noexcept {
        const double way_mm = parameters_.speed_mm_per_s * parameters_.press.since(time);
        const double force_n = force_at(parameters_.press.at(time));
        return {.tip = parameters_.tip,
                .x_mm = parameters_.x_mm + way_mm * heading_.cos,
                .y_mm = parameters_.y_mm + way_mm * heading_.sin,
                .radius_mm = parameters_.tip == DiscContact::Tip::flat
                                 ? parameters_.radius_mm
                                 : DiscContact::sphere_disc_mm(force_n, parameters_.radius_mm, skin_),
                .load_n = force_n,
                .aperture = aperture_};
    }

  private:
    // The load is the depth, where that is given, and otherwise the force.
    double force_at(double load) const noexcept {
        if (!parameters_.depth_mm) return load * parameters_.force_n;
        const double depth_mm = load * *parameters_.depth_mm;
        return parameters_.tip == DiscContact::Tip::flat
                   ? DiscContact::flat_n(depth_mm, parameters_.radius_mm, skin_)
                   : DiscContact::sphere_n(depth_mm, parameters_.radius_mm, skin_);
    }

    Parameters parameters_;
    ElasticSkin skin_;
    Heading heading_;
    Aperture aperture_;
};

static_assert(Stimulus<Indenter>);

}  // namespace afferent
