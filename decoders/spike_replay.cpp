#include "afferent/decoders/spike_replay.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// No spike; far from overflow.
constexpr TimePoint never_fired = scene_start - std::chrono::hours(24 * 365 * 100);

}  // namespace

SpikeReplay::SpikeReplay(const DecodedAfferents& afferents) : index_of_(afferents.addresses, not_read) {
    afferents.check();
    for (const DecodedAfferents::Group& group : afferents.groups) {
        const IntervalDrive drive(group.neuron);
        history_ = std::max(history_, rounded(Seconds(40 * std::max(drive.tau_g_s(), drive.tau_m_s()))));
        groups_.push_back(
            {drive, group.drive_mv_per_n > 0 ? group.threshold_n() : 0, 1 / group.drive_mv_per_n});
    }
    for (const auto& [address, group, share] : afferents.afferents) {
        if (!(share > 0 && afferents.groups[group].drive_mv_per_n > 0)) continue;
        if (!(groups_[group].threshold_n < afferents.largest_grip_n))
            throw ParameterError(
                "patch", "patches that fire within the range of their sensors",
                "silent up to " + std::to_string(afferents.largest_grip_n) + " N of grip force");
        index_of_[address] = static_cast<std::uint32_t>(group_of_.size());
        group_of_.push_back(group);
    }
    require(!group_of_.empty(), "patch", "at least one patch whose elements have a share", 0);
    trains_.resize(group_of_.size());
    restart(scene_start);
}

bool SpikeReplay::solvable(std::uint32_t index, TimePoint time) const noexcept {
    const Train& train = trains_[index];
    if (time <= train.replayed) return false;
    return train.last == train.replayed ||
           seconds(time - train.replayed) > 5 * group_of(index).drive.tau_m_s();
}

void SpikeReplay::fire(std::uint32_t index, TimePoint time) noexcept {
    Train& train = trains_[index];
    const IntervalDrive& drive = group_of(index).drive;
    const Duration interval = std::max(time - train.replayed, Duration(0));
    if (train.last == train.replayed && interval > 0ns) train.rate_hz = 1 / seconds(interval);
    train.g = drive.after_spike(drive.decayed(train.g, interval));
    train.doubt_g = drive.decayed(train.doubt_g, interval);
    train.last = train.replayed = std::max(time, train.replayed);
}

void SpikeReplay::lose(TimePoint begin, TimePoint end) noexcept {
    for (std::uint32_t i = 0; i < afferents(); ++i) {
        Train& train = trains_[i];
        if (end <= train.replayed) continue;
        const IntervalDrive& drive = group_of(i).drive;
        const TimePoint known_until = std::max(train.replayed, begin);
        // The rate that the wait since the last spike allows; none once that is as long ago as the history.
        const Duration waiting = known_until - train.last;
        const double rate_hz = waiting >= history_ ? 0
                               : waiting > 0ns     ? std::min(train.rate_hz, 1 / seconds(waiting))
                                                   : train.rate_hz;
        const Duration lost = end - known_until;
        train.g = drive.driven(drive.decayed(train.g, known_until - train.replayed), lost, rate_hz);
        // A count is off by up to one, and by a third of the spikes as the force may have changed.
        const double spikes = rate_hz * seconds(lost);
        const double doubt_g = drive.after_spike(0) * (0.3 * spikes + std::min(0.4, 2 * spikes));
        train.doubt_g = std::hypot(drive.decayed(train.doubt_g, end - train.replayed), doubt_g);
        train.replayed = end;
    }
}

void SpikeReplay::restart(TimePoint start) noexcept {
    std::fill(trains_.begin(), trains_.end(), Train{.last = never_fired, .replayed = start});
}

void SpikeReplay::resume(const std::vector<Train>& trains) {
    require(trains.size() == trains_.size(), "snapshot.trains", "one for each afferent",
            static_cast<double>(trains.size()));
    trains_ = trains;
}

std::size_t SpikeReplay::heap_bytes() const noexcept {
    return groups_.capacity() * sizeof(Group) +
           (group_of_.capacity() + index_of_.capacity()) * sizeof(std::uint32_t) +
           trains_.capacity() * sizeof(Train);
}

}  // namespace afferent
