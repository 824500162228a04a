// The adaptation of each afferent, replayed from its spikes, and what its intervals tell of the grip force.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/interval_drive.hpp"

namespace afferent {

// For the afferents that feel the grip force. A spike is worth O(1), a loss too, however many afferents there
// are. Allocates nothing after construction.
//
// A start in the middle of a scene may be one in the middle of a grip. The first interval of an afferent then
// gives the rate at which it is presumed to have fired before the start, and so its adaptation; half of that
// adaptation is the standard deviation. At the start of the scene all afferents are at rest.
//
// A spike that ends an interval in which something was lost is held against what is expected: either nothing
// of this afferent was lost, and the interval is as good as any; or a spike was in one of the latest spans
// that were lost, and the interval began there. These are weighed by their chances and by how well they agree
// with what is expected. Where none of them does, the spike tells nothing, and the adaptation goes on as if
// the afferent had fired at its last rate, doubted by a part of that.
class SpikeReplay {
  public:
    struct Train {
        TimePoint last;   // spike
        TimePoint since;  // `g` is that of this time: of the last spike, or of when knowledge began
        double g = 0;
        double doubt_g = 0;  // standard deviation
        double rate_hz = 0;  // of the last interval that is known
        friend bool operator==(const Train&, const Train&) = default;
    };
    struct Group {
        IntervalDrive drive;
        double threshold_n;
        double n_per_mv;
        bool transient;  // then the force is a rate of change, in N/s, throughout
    };
    // The mean force F of an interval, if a spike ends it; otherwise its bound from above.
    struct Measurement {
        double force_n;
        double lag_s;              // how long before its end the mean lies
        double variance_n2;        // from the ticks of the stamps, and the doubt about the adaptation
        double falls_n_per_s = 0;  // how fast the bound falls at the interval's end
    };
    struct Spike {
        Measurement measured;
        TimePoint begin;  // of the interval
        bool known;       // or else nothing is told
    };
    struct Expected {
        double force_n;
        double variance_n2;
    };
    // The last spans that were lost. Who has been silent since before these has lost nothing.
    struct Losses {
        struct Span {
            TimePoint begin, end;
            friend bool operator==(const Span&, const Span&) = default;
        };
        std::array<Span, 32> spans{};  // the latest first
        std::size_t count = 0;
        friend bool operator==(const Losses&, const Losses&) = default;
    };
    struct Snapshot {
        std::vector<Train> trains;
        Losses losses;
        TimePoint start;
        double held_hz;
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };

    // Throws ParameterError: afferents.check(); a sustained afferent with a share of the grip force; each of
    // them fires within the range of the sensors.
    // Forces are in units of unit_n.
    explicit SpikeReplay(const DecodedAfferents& afferents, double unit_n = 1);

    static constexpr std::uint32_t not_read = std::numeric_limits<std::uint32_t>::max();
    // For the afferent with that address.
    std::uint32_t index_of(Address address) const noexcept { return index_of_[address]; }

    std::uint32_t afferents() const noexcept { return static_cast<std::uint32_t>(trains_.size()); }
    std::uint32_t group(std::uint32_t index) const noexcept { return group_of_[index]; }
    const Group& group_of(std::uint32_t index) const noexcept { return groups_[group_of_[index]]; }
    const Train& train(std::uint32_t index) const noexcept { return trains_[index]; }

    // Whether something of it may have been lost since it was heard last.
    bool lost_since(std::uint32_t index) const noexcept {
        return losses_.count > 0 && losses_.spans[0].end > trains_[index].since;
    }
    // How much of that time was lost, by the latest spans.
    Duration lost_between(TimePoint begin, TimePoint end) const noexcept;
    // A spike, and what it tells; where something may have been lost, by what is expected.
    Spike hear(std::uint32_t index, TimePoint time) noexcept;
    Spike hear(std::uint32_t index, TimePoint time, const Expected& expected) noexcept;
    // `force_n`, of the force that the last spike has told, is known from elsewhere: what it told otherwise
    // puts the doubtful adaptation right.
    void correct(std::uint32_t index, const Measurement& measured, const Expected& force) noexcept;
    // How much of the force that the last spike measured was needed against the adaptation.
    double adaptation_n(std::uint32_t index) const noexcept {
        const Group& group = group_of(index);
        return trains_[index].g * group.drive.excess_per_g_mv() * group.n_per_mv;
    }
    // The largest standard deviation that unknown adaptation from before the start gives a force. The error
    // is common to all afferents, so averaging over them does not reduce it; it decays with the slowest
    // adaptation.
    double unknown_since_start_n(TimePoint until) const noexcept;
    // A force whose standard deviation by unknown adaptation exceeds this part of it is not known well.
    static constexpr double well_known = 0.25;
    // That there has been none until then; infinite where nothing is known.
    Measurement silent(std::uint32_t index, TimePoint until) const noexcept;
    // The same, if no spike was lost since the last one.
    Measurement silent_if_none_lost(std::uint32_t index, TimePoint until) const noexcept;
    // How many spikes of it are to be expected in what was lost since the last one.
    double lost_spikes(std::uint32_t index, TimePoint until) const noexcept {
        return lost_since(index) ? lost_within(trains_[index], until).spikes : 0;
    }
    // Nothing is known of [begin, end). Begins do not decrease.
    void lose(TimePoint begin, TimePoint end) noexcept;

    void restart(TimePoint start) noexcept;
    Snapshot snapshot() const { return {trains_, losses_, start_, held_hz_}; }
    // Throws ParameterError, and changes nothing, if it is of another number of afferents.
    void resume(const Snapshot& snapshot);

    // Until adaptation and membrane are forgotten: e^−40 is less than half a unit in the last place of 1.
    Duration history() const noexcept { return history_; }
    std::size_t heap_bytes() const noexcept;

  private:
    // What is lost since the afferent was heard: from the first to the last moment, and how many spikes are
    // to be expected in it.
    struct Lost {
        TimePoint begin, end;
        double spikes;
    };
    Lost lost_within(const Train& train, TimePoint until) const noexcept;
    double spikes_within(const Train& train, TimePoint begin, TimePoint end) const noexcept;
    struct Adaptation {
        double g, doubt_g;
    };
    Adaptation after_loss(const Group& group, const Train& train, const Lost& lost) const noexcept;
    Measurement measurement(const Group& group, double doubt_g,
                            const IntervalDrive::Solution& solution) const noexcept;
    // The standard deviation of the adaptation at the start, in steps of one spike.
    double doubted_spikes(double tau_g_s) const noexcept;
    void presume_held(Train& train, const IntervalDrive& drive, Duration interval) noexcept;
    void fire(Train& train, TimePoint time, double g, double doubt_g) noexcept;
    // What a spike would mean, the adaptation before it, and how likely that is.
    struct Hypothesis {
        Measurement measured;
        TimePoint begin;
        double g, doubt_g;
        double weight;
    };
    Hypothesis none_lost(std::uint32_t index, TimePoint time) const noexcept;
    // The last spike was lost in that span.
    Hypothesis lost_in(std::uint32_t index, const Losses::Span& span, std::size_t earlier_spans,
                       TimePoint time) const noexcept;
    Spike hear_after_loss(std::uint32_t index, TimePoint time, Lost lost, const Expected& expected) noexcept;

    std::vector<Group> groups_;
    std::vector<std::uint32_t> group_of_;
    std::vector<std::uint32_t> index_of_;
    std::size_t table_bytes_ = 0;  // those that others share are counted by each
    double tick_s_;
    Duration history_{};
    // The largest of all groups.
    double tau_g_s_ = 0;
    double step_n_ = 0;  // the force that one spike's adaptation is worth
    std::vector<Train> trains_;
    Losses losses_;
    TimePoint start_ = scene_start;
    double held_hz_ = 0;  // of the shortest first interval since the start
};

}  // namespace afferent
