// The change that all pressures under a contact share, such as that of a lift, by transient afferents.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/silence.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// A transient afferent is driven by the slope of the pressure under its field, and its membrane integrates
// the drive: at rest it fires once the pressure has changed by an amount q of its own. If the change takes
// the time T, that is
//
//     q(T) = q x/(1 − e^(−x)),      x = T/tau_m,      q = rheobase · tau_m/gain
//
// and 1/negative_ratio of it for a fall. So every transient afferent under the contact, whether it fires or
// not, bounds the change as a part of the pressure that was held. It does not tell a fall from a rise.
// Sustained afferents do: a rise makes them fire at once, a fall silences them.
//
// The posterior of the change is computed on a grid. Its mean never raises a pressure: the spikes of
// sustained afferents measure a rise at once. Not told: changes so slow that q(T) exceeds the pressure.
//
// A spike costs O(1), or O(sustained afferents) where it begins a change. A posterior costs some 60 products
// for each afferent. Memory: some 110 bytes for each transient afferent, and four for each address. Allocates
// nothing after construction.
class CommonChange {
  public:
    struct Transient {
        Address address;
        SkinField field;
        // The sudden changes of the mean pressure under its field that make it fire, q; both > 0.
        double fall_n_per_mm2, rise_n_per_mm2;
        double tau_m_s;
        friend bool operator==(const Transient&, const Transient&) = default;
    };
    // What one sustained afferent tells of the change. Pressures are in N/mm².
    struct Sustained {
        double held = 0;      // pressure before the change; 0: none
        double measured = 0;  // pressure after it; 0: not measured yet
        // The present bound by its silence.
        double at_most = std::numeric_limits<double>::infinity();
        bool rises = false;  // it has measured a rise, or feels the contact for the first time
    };
    // Multiplies the pressures that were measured before the change.
    struct Factor {
        double mean = 1;
        double sigma = 0;  // one standard deviation
        friend bool operator==(const Factor&, const Factor&) = default;
    };
    struct Snapshot {
        std::vector<std::uint8_t> works;
        std::vector<std::uint32_t> spikes;
        std::vector<double> held;
        TimePoint begin, end;
    };

    // Within this time of the first spike, sustained afferents may have fired before the change or during it.
    static constexpr Duration sudden = 20ms;
    static constexpr std::uint32_t not_read = std::numeric_limits<std::uint32_t>::max();

    // `sustained`: the fields of the afferents that measure the pressures. Throws ParameterError unless there
    // is one where there are transient afferents, and each of these has an address below `addresses`, and
    // changes and a time constant > 0.
    CommonChange(std::size_t addresses, std::span<const SkinField> sustained,
                 std::vector<Transient> transients);

    std::uint32_t index_of(Address address) const noexcept {
        return transients_.empty() ? not_read : index_of_[address];
    }

    // Call hear() for each spike of a transient afferent, and begin() before it if begins(), which is true
    // after a pause, and the afferent feels() a pressure. Pressures are in N/mm², by sustained afferent. If
    // the change is not common, none is told until the next pause.
    bool begins(TimePoint time) const noexcept;
    bool feels(std::uint32_t index, std::span<const double> pressures) const noexcept;
    void begin(TimePoint time, std::span<const double> pressures, bool common) noexcept;
    void hear(std::uint32_t index, TimePoint time) noexcept;

    // The last change, if there is one: its first and its last spike, and the pressures before it.
    bool happened() const noexcept { return begin_ != never_fired; }
    TimePoint began() const noexcept { return begin_; }
    TimePoint ended() const noexcept { return end_; }
    std::span<const double> held() const noexcept { return held_; }

    // tell(i) returns what is known from the i-th sustained afferent. `heard` is the part of the change's
    // time that was not lost.
    template <class Tell>
    Factor factor(double heard, const Tell& tell) const noexcept {
        Posterior posterior = prior_;
        for (std::uint32_t i = 0; i < transients_.size(); ++i) add(i, heard, posterior);
        for (std::uint32_t i = 0; i < held_.size(); ++i) add(tell(i), posterior);
        return mean_of(posterior);
    }

    void restart() noexcept;
    Snapshot snapshot() const { return {works_, spikes_, held_, begin_, end_}; }
    // Throws ParameterError if it is of another number of afferents.
    void resume(const Snapshot& snapshot);

    std::size_t heap_bytes() const noexcept;

  private:
    // The grid, as parts of the pressures that were held: falls down to −1; no change; rises; and the same
    // rises from pressures that had fallen unnoticed, which sustained afferents need not feel.
    static constexpr std::size_t steps = 20;
    static constexpr std::size_t from_below = 2 * steps + 1;
    static constexpr std::size_t changes = from_below + steps;
    using Posterior = std::array<double, changes>;
    static constexpr std::size_t nearest = 4;
    struct Neighbours {
        std::array<std::uint32_t, nearest> index{};
        std::array<double, nearest> weight{};
    };

    Neighbours neighbours_of(const SkinField& field, std::span<const SkinField> sustained) const;
    // The pressure under the field of a transient afferent, by interpolation.
    double felt_by(std::uint32_t index, std::span<const double> pressures) const noexcept;
    void add(std::uint32_t index, double heard, Posterior& posterior) const noexcept;
    void add(const Sustained& told, Posterior& posterior) const noexcept;
    // Multiplies the first values of the grid by likelihood(change).
    template <class Likelihood>
    void multiply(Posterior& posterior, const Likelihood& likelihood,
                  std::size_t first_changes = changes) const noexcept;
    Factor mean_of(const Posterior& posterior) const noexcept;

    std::vector<Transient> transients_;
    std::vector<std::uint32_t> index_of_;
    std::vector<Neighbours> neighbours_;
    std::array<double, changes> change_{};
    Posterior prior_{};
    std::vector<std::uint8_t> works_;    // whether it has ever fired
    std::vector<std::uint32_t> spikes_;  // of the change
    std::vector<double> held_;
    TimePoint begin_ = never_fired;
    TimePoint end_ = never_fired;  // the last spike under the contact
};

}  // namespace afferent
