// Where and how hard a patch of skin is touched: force, centre, area and motion of contacts.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/decoders/field_pressures.hpp"
#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/readout.hpp"

namespace afferent {

// The spikes and the silence of each afferent tell of the pressure under its receptive field
// (field_pressures.hpp), and a contact is fitted to all of these pressures (pressure_fit.hpp), so that force,
// centre and area are those of the skin, between the fields as well, without the width of the fields:
//
//     force = Σ p a,     centre = Σ p a x / force,     area = 1.1 (Σ p a)² / Σ p² a
//
// over the patch's elements, of the area a and under the pressure p. A pressure that is the same everywhere
// fills (Σ p a)²/Σ p² a. For Hertz's it is 1/1.08 of the contact of a cylinder and 1/1.125 of that of a
// sphere; 1.1 lies between.
//
// There are two contacts where two shapes fit the pressures better than one by more than what the shape of a
// single contact explains. More than two come out as two. One contact moves where a velocity makes it fit the
// pressures at the times at which they were measured: then the force is that of the present place, without
// what it has left behind. Two contacts are taken to stand.
//
// Transient afferents tell that a contact ends or is pressed less, long before the silence of sustained ones
// does (common_change.hpp).
//
// A spike costs O(1). With 75 afferents and 424 elements an estimate takes 0.3 ms, 0.9 ms of a contact that
// slides and 2 ms of two contacts. Memory: 1 kB for each afferent. Allocates nothing after construction.
class ContactReadout {
  public:
    struct Afferent {
        Address address;
        // Its drive for each unit of the mean pressure under its field, in place of newtons of grip.
        DecodedAfferents::Group group;
        double unit_n_per_mm2;
        SkinField field;
        friend bool operator==(const Afferent&, const Afferent&) = default;
    };
    struct Parameters {
        std::size_t addresses = 0;  // in the stream
        PatchIndex patch{};
        Duration interval = 10ms;  // between estimates; > 0
        std::vector<Afferent> afferents{};
        // Transient afferents on the same skin; may be empty.
        std::vector<CommonChange::Transient> transients{};
        // The patch's elements.
        std::vector<SkinField> elements{};
        double element_mm2 = 1;
        Duration scan{};
        Duration tick = 1ns;
        double hysteresis = 0;
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };
    struct Snapshot {
        FieldPressures::Snapshot pressures;
        std::int64_t intervals;
    };
    using Readout = PatchContact;
    // Over a run.
    struct Totals {
        double largest_force_n = 0;
        void add(const PatchContact& contact) noexcept {
            largest_force_n = std::max(largest_force_n, contact.estimate.force_n);
        }
        void add_to(auto& summary, const std::string& patch) const {
            summary["largest_contact_force_n"][patch] = largest_force_n;
        }
    };

    static constexpr std::size_t most_contacts = 2;
    // The unit of the pressure on an afferent is such that it begins to fire at this many of them.
    static constexpr double units_at_threshold = 0.3;

    // At least one afferent and one element. Throws ParameterError, as SpikeReplay does.
    explicit ContactReadout(const Parameters& parameters);

    // As of a decoder (decoder.hpp).
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        pressures_.observe(begin, end, events);
    }
    void lose(TimePoint begin, TimePoint end) { pressures_.lose(begin, end); }
    void presume_silence(TimePoint until) { pressures_.presume_silence(until); }
    void restart(TimePoint start) { pressures_.resume_after(start, start); }
    // The last step was at `start`.
    void resume_after(TimePoint start, TimePoint heard_until) {
        pressures_.resume_after(start, heard_until);
        intervals_ = intervals_until(start);
    }
    Duration history() const { return pressures_.history(); }
    Snapshot snapshot() const { return {pressures_.snapshot(), intervals_}; }
    void resume(const Snapshot& snapshot) {
        pressures_.resume(snapshot.pressures);
        intervals_ = snapshot.intervals;
    }

    PatchIndex patch() const noexcept { return patch_; }
    // The contacts at the first step of each interval, that of the largest force first; where there is none,
    // one that no afferent feels. Valid until the next call. Times of steps do not decrease.
    std::span<const PatchContact> step(TimePoint now);
    std::span<const PatchContact> contacts(TimePoint now);

    std::size_t bytes() const;

  private:
    struct Sums {
        double force_n, x_mm, y_mm, area_mm2;
        double full_n;  // on elements that are at full scale
    };
    struct Fitted {
        PressureFit::Solution solution;
        PressureShape shape;
    };
    std::int64_t intervals_until(TimePoint time) const noexcept { return (time - scene_start) / interval_; }
    Sums sums_of(const PressureShape& shape) const noexcept;
    using Readings = std::span<const PressureFit::Reading>;
    Fitted fit(Readings readings, bool moves = false) const noexcept;
    // Contacts differ from the shape that is fitted, the more the higher the pressure is.
    static void blur(std::span<PressureFit::Reading> readings, double highest) noexcept;
    double read_by(std::span<const Fitted> contacts, std::size_t reading, double age_s) const noexcept;
    // The sum of the squares of what the readings are off; with `felt`, of those that feel a contact.
    double misfit(Readings readings, std::span<const Fitted> contacts, bool felt) const noexcept;
    // One contact that moves, and the sum of the squares of what its readings at their times are off. Nothing
    // where one that stands is off by hardly more.
    struct Moving {
        Fitted fitted;
        double misfit;
    };
    std::optional<Moving> fit_moving(TimePoint now, const CommonChange::Factor& change, const Fitted& one,
                                     double highest) noexcept;
    // Sorts the afferents into those that are nearer to one and to the other of two middles.
    bool divide() noexcept;
    std::optional<std::array<Fitted, 2>> fit_two(const Fitted& one) noexcept;
    // What the readings' misfits tell of the estimate.
    struct Doubt {
        double excess;  // by which its variances are too small
        double unfelt;  // as a part of the force, what dead elements may not have felt
    };
    // `followed`: as many of the readings as the fit follows, whatever they are.
    Doubt doubt(Readings readings, std::span<const Fitted> contacts, std::uint32_t felt,
                std::size_t followed) const noexcept;
    ContactEstimate estimate(const Fitted& fitted, const Doubt& doubt,
                             double common_sigma = 0) const noexcept;
    static void add_velocity(const Fitted& fitted, const Doubt& doubt, ContactEstimate& estimate) noexcept;

    PatchIndex patch_;
    Duration interval_;
    std::int64_t intervals_ = -1;  // begun by the last step
    FieldPressures pressures_;
    PressureFit fit_;
    std::vector<SkinField> elements_;
    double element_mm2_;
    double full_scale_;  // of an element, in N/mm²
    std::vector<PressureFit::Reading> readings_;
    std::vector<PressureFit::Reading> rest_;  // what the other contact leaves of the readings
    std::vector<PressureFit::Reading> at_their_times_;
    std::vector<std::uint8_t> side_;  // of two contacts, by afferent
    std::array<PatchContact, most_contacts> told_{};
};

}  // namespace afferent
