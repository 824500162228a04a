// Read-outs of a patch: the contact, the edges and the texture on it. Included by programs that read
// ControllerStep::readouts.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "afferent/runtime/time.hpp"

namespace afferent {

// The index of a patch among the scene's.
struct PatchIndex {
    std::uint32_t value = 0;
    friend bool operator==(const PatchIndex&, const PatchIndex&) = default;
};

// Force, centre and area of a contact, with one standard deviation of each. Positions are in the patch's own
// coordinates.
struct ContactEstimate {
    // How many afferents respond to the contact. If 0, there is no contact: force and area are 0, and the
    // position is meaningless.
    std::uint32_t afferents = 0;
    double force_n = 0, force_sigma_n = 0;
    double x_mm = 0, x_sigma_mm = 0;
    double y_mm = 0, y_sigma_mm = 0;
    double area_mm2 = 0, area_sigma_mm2 = 0;
    // Whether it moves over the skin, and how fast. Along its length little is known of that.
    bool slides = false;
    double velocity_x_mm_per_s = 0, velocity_x_sigma_mm_per_s = 0;
    double velocity_y_mm_per_s = 0, velocity_y_sigma_mm_per_s = 0;

    friend bool operator==(const ContactEstimate&, const ContactEstimate&) = default;
};

// Orientation and motion of an edge on the skin.
struct EdgeEstimate {
    bool slides = false;
    // Counted from x towards y, 0 <= orientation < 180, with one standard deviation. As an edge turned by 180
    // degrees is the same edge, a deviation of 52 degrees or more means that the orientation is unknown.
    double orientation_deg = 0;
    double sigma_deg = 0;
    // The direction of sliding: 0 <= direction < 360.
    double direction_deg = 0;
    double speed_mm_per_s = 0;
    double speed_sigma_mm_per_s = 0;

    friend bool operator==(const EdgeEstimate&, const EdgeEstimate&) = default;
};

// What slides over the skin: its wave, if it has one, and its roughness. Each number has one standard
// deviation.
struct TextureEstimate {
    // Afferents fire in phase with an oscillation.
    bool oscillates = false;
    double frequency_hz = 0, frequency_sigma_hz = 0;
    // Their phases are those of a plane wave that travels over the skin: a periodic surface slides.
    bool slides = false;
    double period_mm = 0, period_sigma_mm = 0;
    double direction_deg = 0, direction_sigma_deg = 0;  // of sliding: 0 <= direction < 360
    double speed_mm_per_s = 0, speed_sigma_mm_per_s = 0;
    // Spatial variation of the rates (decoders/spatial_variation.hpp).
    bool felt = false;
    double roughness_hz = 0, roughness_sigma_hz = 0;

    friend bool operator==(const TextureEstimate&, const TextureEstimate&) = default;
};

// Each kind of read-out describes its columns once: columns() passes each name with its value, which is a
// TimePoint, a PatchIndex, a count or a number; an empty number is unknown. All tables of read-outs, in files
// and in Python, have these columns. `table` is the name of the table.

// One of the contacts with a patch at `time`, or that there is none.
struct PatchContact {
    static constexpr const char* table = "contact";

    TimePoint time{};
    PatchIndex patch;
    std::uint32_t contact = 0;  // counted from that of the largest force
    ContactEstimate estimate{};

    void columns(auto&& column) const {
        const auto where_found = [this](double value) {
            return estimate.afferents > 0 ? std::optional(value) : std::nullopt;
        };
        column("time", time);
        column("patch", patch);
        column("contact", contact);
        column("afferents", estimate.afferents);
        column("force_n", estimate.force_n);
        column("force_sigma_n", estimate.force_sigma_n);
        column("x_mm", where_found(estimate.x_mm));
        column("x_sigma_mm", where_found(estimate.x_sigma_mm));
        column("y_mm", where_found(estimate.y_mm));
        column("y_sigma_mm", where_found(estimate.y_sigma_mm));
        column("area_mm2", estimate.area_mm2);
        column("area_sigma_mm2", estimate.area_sigma_mm2);
        const auto where_slides = [this](double value) {
            return estimate.slides ? std::optional(value) : std::nullopt;
        };
        column("velocity_x_mm_per_s", where_slides(estimate.velocity_x_mm_per_s));
        column("velocity_x_sigma_mm_per_s", where_slides(estimate.velocity_x_sigma_mm_per_s));
        column("velocity_y_mm_per_s", where_slides(estimate.velocity_y_mm_per_s));
        column("velocity_y_sigma_mm_per_s", where_slides(estimate.velocity_y_sigma_mm_per_s));
    }
    friend bool operator==(const PatchContact&, const PatchContact&) = default;
};

// An edge that has touched a patch.
struct EdgeTouch {
    static constexpr const char* table = "touches";

    TimePoint begin{};  // its first spike
    PatchIndex patch;
    TimePoint told{};             // from then on no further afferent can join it
    std::uint32_t afferents = 0;  // whose first spikes belong to it
    EdgeEstimate edge{};

    void columns(auto&& column) const {
        const auto where_it_slides = [this](double value) {
            return edge.slides ? std::optional(value) : std::nullopt;
        };
        column("time", begin);
        column("patch", patch);
        column("told", told);
        column("afferents", afferents);
        column("orientation_deg", edge.orientation_deg);
        column("orientation_sigma_deg", edge.sigma_deg);
        column("direction_deg", where_it_slides(edge.direction_deg));
        column("speed_mm_per_s", where_it_slides(edge.speed_mm_per_s));
        column("speed_sigma_mm_per_s", where_it_slides(edge.speed_sigma_mm_per_s));
    }
    friend bool operator==(const EdgeTouch&, const EdgeTouch&) = default;
};

// What has slid over a patch in a window of time.
struct PatchTexture {
    static constexpr const char* table = "texture";

    TimePoint end{};  // of the window
    PatchIndex patch;
    std::uint32_t afferents = 0;  // that have fired
    std::uint32_t events = 0;
    TextureEstimate estimate{};

    void columns(auto&& column) const {
        const auto where = [](bool known, double value) {
            return known ? std::optional(value) : std::nullopt;
        };
        const TextureEstimate& e = estimate;
        column("time", end);
        column("patch", patch);
        column("afferents", afferents);
        column("events", events);
        column("frequency_hz", where(e.oscillates, e.frequency_hz));
        column("frequency_sigma_hz", where(e.oscillates, e.frequency_sigma_hz));
        column("period_mm", where(e.slides, e.period_mm));
        column("period_sigma_mm", where(e.slides, e.period_sigma_mm));
        column("direction_deg", where(e.slides, e.direction_deg));
        column("direction_sigma_deg", where(e.slides, e.direction_sigma_deg));
        column("speed_mm_per_s", where(e.slides, e.speed_mm_per_s));
        column("speed_sigma_mm_per_s", where(e.slides, e.speed_sigma_mm_per_s));
        column("roughness_hz", where(e.felt, e.roughness_hz));
        column("roughness_sigma_hz", where(e.felt, e.roughness_sigma_hz));
    }
    friend bool operator==(const PatchTexture&, const PatchTexture&) = default;
};

// Any kind of read-out.
using PatchReadout = std::variant<PatchContact, EdgeTouch, PatchTexture>;

}  // namespace afferent
