// The wave that an indenter sends through the skin around it.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/hand/indenter.hpp"
#include "afferent/hand/stimulus.hpp"

namespace afferent {

// Outside the contact of a force F on a disc of radius R, at a distance r from its middle,
//
//     p(r, t) = 3 F(t − r/speed) / (2π depth²) · (2/π) arcsin(R/r)
//
// the pressure under a point load at the depth of the afferents (Boussinesq), as much less as the surface is
// deflected less outside a flat punch (Johnson, Contact Mechanics, 1985, section 3.8), and later by the time
// that a wave takes (Manfredi et al. 2012, PLoS ONE 7:e31203, have its speed and decay in a finger).
class WaveAround {
  public:
    // Valid as long as the indenter and the wave are.
    WaveAround(const Indenter& indenter, const SkinWave& wave, double element_mm2, TimePoint time,
               bool passes)
        : indenter_(indenter),
          wave_(wave),
          element_mm2_(element_mm2),
          time_(time),
          reach_mm_(passes ? wave.reach_mm : 0) {
        const DiscContact contact = indenter.at(time);
        middle_ = {contact.x_mm, contact.y_mm};
    }

    Stretch rows() const noexcept { return {middle_.y_mm - reach_mm_, middle_.y_mm + reach_mm_}; }
    Stretch columns(double row_mm) const noexcept {
        const double off_mm = row_mm - middle_.y_mm;
        const double half_mm = std::sqrt(std::max(0.0, reach_mm_ * reach_mm_ - off_mm * off_mm));
        return {middle_.x_mm - half_mm, middle_.x_mm + half_mm};
    }
    double force_n(const Position& place) const noexcept {
        const double r_mm = std::hypot(place.x_mm - middle_.x_mm, place.y_mm - middle_.y_mm);
        const DiscContact sent = indenter_.at(time_ - wave_.delay(r_mm));
        if (!(r_mm > sent.radius_mm)) return 0;
        const double at_depth = 3 * sent.load_n / (2 * std::numbers::pi * wave_.depth_mm * wave_.depth_mm);
        return at_depth * 2 / std::numbers::pi * std::asin(sent.radius_mm / r_mm) * element_mm2_;
    }

  private:
    const Indenter& indenter_;
    const SkinWave& wave_;
    double element_mm2_;
    TimePoint time_;
    double reach_mm_;
    Position middle_;
};

class IndenterWave {
  public:
    IndenterWave(const IndenterParameters& parameters, const ElasticSkin& skin, const SkinWave& wave,
                 const Aperture& aperture)
        : press_(parameters.press),
          indenter_(parameters, skin, aperture),
          wave_(wave),
          element_mm2_(aperture.pitch_mm() * aperture.pitch_mm()) {}

    WaveAround at(TimePoint time) const noexcept {
        const double since_s = press_.since(time);
        const double last_s = press_.rise_s + press_.hold_s + press_.fall_s;
        return {indenter_, wave_, element_mm2_, time,
                since_s >= 0 && since_s <= last_s + seconds(wave_.delay(wave_.reach_mm))};
    }

  private:
    Press press_;
    Indenter indenter_;
    SkinWave wave_;
    double element_mm2_;
};

static_assert(Stimulus<IndenterWave>);

}  // namespace afferent
