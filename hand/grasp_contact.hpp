// Where a finger or the palm holds an object.
#pragma once

#include <vector>

#include "afferent/hand/disc_contact.hpp"
#include "afferent/hand/stimulus.hpp"
#include "afferent/runtime/piecewise_linear.hpp"

namespace afferent {

// A share of the grip force, on a contact as of a sphere (Hertz), whose radius grows with the cube root of
// the force.
class GraspContact {
  public:
    // The grip force is linear between the points, and held before the first and after the last.
    GraspContact(double x_mm, double y_mm, double share, double sphere_mm, std::vector<GripPoint> grip,
                 const ElasticSkin& skin, const Aperture& aperture)
        : x_mm_(x_mm),
          y_mm_(y_mm),
          share_(share),
          sphere_mm_(sphere_mm),
          grip_(std::move(grip)),
          skin_(skin),
          aperture_(aperture) {
        DiscContact::make_table(DiscContact::Tip::sphere);
    }

    DiscContact at(TimePoint time) const noexcept {
        const double force_n =
            share_ * interpolate(grip_, &GripPoint::time_s, &GripPoint::force_n, seconds(time));
        return {.tip = DiscContact::Tip::sphere,
                .x_mm = x_mm_,
                .y_mm = y_mm_,
                .radius_mm = DiscContact::sphere_disc_mm(force_n, sphere_mm_, skin_),
                .load_n = force_n,
                .aperture = aperture_};
    }

  private:
    double x_mm_;
    double y_mm_;
    double share_;
    double sphere_mm_;
    std::vector<GripPoint> grip_;
    ElasticSkin skin_;
    Aperture aperture_;
};

static_assert(Stimulus<GraspContact>);

}  // namespace afferent
