// The adaptation of each afferent, replayed from its spikes, and what its intervals tell of the grip force.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/interval_drive.hpp"

namespace afferent {

// For the afferents that feel the grip force. In lost time the adaptation goes on as if they had fired at
// their last rate, and is doubted by a part of what they fired. Allocates nothing after construction.
class SpikeReplay {
  public:
    struct Train {
        TimePoint last;      // spike
        TimePoint replayed;  // `g` is that of this time: of the last spike, or of the end of a lost span
        double g = 0;
        double doubt_g = 0;  // standard deviation
        double rate_hz = 0;  // of the last interval that is known
        friend bool operator==(const Train&, const Train&) = default;
    };
    struct Group {
        IntervalDrive drive;
        double threshold_n;
        double n_per_mv;
    };

    // Throws ParameterError: afferents.check(); an afferent with a share of the grip force; each of them
    // fires within the range of the sensors.
    explicit SpikeReplay(const DecodedAfferents& afferents);

    static constexpr std::uint32_t not_read = std::numeric_limits<std::uint32_t>::max();
    // For the afferent with that address.
    std::uint32_t index_of(Address address) const noexcept { return index_of_[address]; }

    std::uint32_t afferents() const noexcept { return static_cast<std::uint32_t>(trains_.size()); }
    const Group& group_of(std::uint32_t index) const noexcept { return groups_[group_of_[index]]; }
    const Train& train(std::uint32_t index) const noexcept { return trains_[index]; }
    const std::vector<Train>& trains() const noexcept { return trains_; }

    // Whether a spike at `time` ends an interval that can be solved: it is known, and so is its begin, or the
    // silence in it is so long that the begin does not matter.
    bool solvable(std::uint32_t index, TimePoint time) const noexcept;
    // The mean force of the interval up to `until`, if there is a spike then; otherwise its bound from above.
    double force_n(std::uint32_t index, TimePoint until) const noexcept {
        const Group& group = group_of(index);
        const Train& train = trains_[index];
        return group.threshold_n + group.drive.excess_mv(train.g, until - train.replayed) * group.n_per_mv;
    }
    void fire(std::uint32_t index, TimePoint time) noexcept;
    // Nothing is known of [begin, end).
    void lose(TimePoint begin, TimePoint end) noexcept;
    void restart(TimePoint start) noexcept;
    // Throws ParameterError, and changes nothing, if they are of another number of afferents.
    void resume(const std::vector<Train>& trains);

    // Until adaptation and membrane are forgotten: e^−40 is less than half a unit in the last place of 1.
    Duration history() const noexcept { return history_; }
    std::size_t heap_bytes() const noexcept;

  private:
    std::vector<Group> groups_;
    std::vector<std::uint32_t> group_of_;
    std::vector<std::uint32_t> index_of_;
    Duration history_{};
    std::vector<Train> trains_;
};

}  // namespace afferent
