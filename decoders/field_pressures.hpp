// What the spikes and the silence of afferents tell of the pressures under their receptive fields.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/common_change.hpp"
#include "afferent/decoders/hysteresis_branch.hpp"
#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/spike_replay.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The interval that a spike ends measures the pressure of the last few milliseconds before it, given the
// adaptation (spike_replay.hpp). Silence since then bounds the pressure from above by what would have made
// the afferent fire: a long way above a pressure to which it has adapted. No motion of the pressure is
// presumed. A measurement that grows old is as uncertain as the pressures have changed lately, wherever on
// the skin, by what spikes have measured and by the silence of afferents that should have fired; what an
// afferent has said before a loss, as if they had changed quickly meanwhile.
//
// Transient afferents on the same skin tell a change that all pressures under the contact share
// (common_change.hpp): its factor multiplies what was measured before it. Without their spikes, the readings
// are those of the sustained afferents alone.
//
// A spike costs O(1), the readings O(1) for each afferent. Memory: less than 1 kB for each afferent and four
// bytes for each address, beside the tables of SpikeReplay and CommonChange. Allocates nothing after
// construction.
class FieldPressures {
  public:
    // The last measurement of an afferent, in its own unit.
    struct Last {
        double pressure = 0;  // 0: none
        double variance = 0;
        double change_per_s = 0;  // since the measurement before
        TimePoint time{};         // of what was measured
        // How long the afferent had been silent before; the longest duration if it had never fired.
        Duration interval{};
        friend bool operator==(const Last&, const Last&) = default;
    };
    struct Snapshot {
        SpikeReplay::Snapshot replay;
        std::vector<Last> last;
        std::vector<HysteresisBranch> branches;
        CommonChange::Snapshot change;
        bool slides;
        TimePoint heard_until, presumed_until, counted_from;
    };

    // The groups of `afferents` fire by the mean pressure under a field in units, whose size, in N/mm², is
    // that of each afferent. `fields`: one for each afferent if there are transient ones. Throws
    // ParameterError, as SpikeReplay and CommonChange do.
    FieldPressures(const DecodedAfferents& afferents, std::vector<double> unit_n_per_mm2,
                   std::span<const SkinField> fields = {},
                   std::vector<CommonChange::Transient> transients = {});

    // As of a decoder (decoder.hpp).
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept;
    void presume_silence(TimePoint until) noexcept;
    void resume_after(TimePoint start, TimePoint heard_until) noexcept;
    Duration history() const noexcept { return replay_.history(); }
    Snapshot snapshot() const;
    // Throws ParameterError if it is of another number of afferents.
    void resume(const Snapshot& snapshot);

    // The last common change, as known at `now`: its factor multiplies the pressures measured before it.
    CommonChange::Factor change(TimePoint now) const noexcept;
    // The pressures at `now`, in N/mm², as many as there are afferents; how many of these feel one.
    std::uint32_t read(TimePoint now, std::span<PressureFit::Reading> readings,
                       const CommonChange::Factor& change = {}) const noexcept;
    // For contacts that move: what has been measured of each afferent, at the age that it has, and then what
    // silence bounds now. Twice as many as there are afferents.
    void read_at_their_times(TimePoint now, std::span<PressureFit::Reading> readings,
                             const CommonChange::Factor& change = {}) const noexcept;
    // The standard deviation of the error that the change gives all pressures together, as a part of them.
    double common_sigma(TimePoint now, const CommonChange::Factor& change) const noexcept;
    // While a contact slides, pressures rise and fall side by side: a change that begins then is not common.
    void take_for_sliding(bool slides) noexcept { slides_ = slides; }

    std::size_t heap_bytes() const noexcept;

  private:
    // What silence leaves possible, in the afferent's own unit; infinite, without sigma, where that reaches
    // full scale.
    struct Bound {
        double pressure, sigma;
        double at_most() const noexcept;
    };

    void take(std::uint32_t index, TimePoint time) noexcept;
    void take_transient(std::uint32_t index, TimePoint time) noexcept;
    TimePoint known_until(TimePoint now) const noexcept {
        return std::min(now, std::max(heard_until_, presumed_until_));
    }
    CommonChange::Sustained tell_change(std::uint32_t index, TimePoint until) const noexcept;
    // The last measurement, multiplied by the factor if it is older than the change.
    Last changed(std::uint32_t index, const CommonChange::Factor& change) const noexcept;
    double sensor_sigma(std::uint32_t index, double pressure) const noexcept;
    // The root mean square of the recent changes, in N/mm² a second. It contains the changes that spikes have
    // measured, and the falls that silence up to `until` implies.
    double change_per_s(TimePoint until, TimePoint now, const CommonChange::Factor& change) const noexcept;
    Bound bound(std::uint32_t index, TimePoint until) const noexcept;
    // Since it was measured, where it may change by that part in a second that was heard.
    double may_have_changed(const Last& last, TimePoint now, double per_s) const noexcept;
    // The highest pressure that a measurement of that age leaves possible.
    static double settled(const Last& last, const Bound& bound, double age_s) noexcept;
    PressureFit::Reading reading(std::uint32_t index, const Last& last, TimePoint until, TimePoint now,
                                 double change_per_s) const noexcept;

    // The sensors under an afferent, in the afferent's own unit.
    struct Sensing {
        double full_scale, noise, noise_fraction;
    };

    SpikeReplay replay_;
    std::vector<double> unit_n_per_mm2_;
    std::vector<Sensing> sensing_{};
    std::vector<Last> last_;
    std::vector<HysteresisBranch> branches_;
    HysteresisBranch untouched_;
    CommonChange change_;
    std::vector<double> held_;  // scratch for take_transient
    bool slides_ = false;
    Duration scan_;
    TimePoint heard_until_{}, presumed_until_{};
    TimePoint counted_from_{};  // events before it, or in a span that is lost, do not count
};

}  // namespace afferent
