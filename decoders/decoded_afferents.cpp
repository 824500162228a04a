#include "afferent/decoders/decoded_afferents.hpp"

#include <algorithm>

#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

double DecodedAfferents::Group::rate_hz(RateKind kind, double grip_n) const {
    return afferent::rate_hz(kind, neuron, drive_mv_per_n * grip_n + bias_mv);
}

double DecodedAfferents::Group::grip_n(RateKind kind, double rate_hz) const {
    return grip_n(drive_mv(kind, neuron, rate_hz));
}

double DecodedAfferents::Group::threshold_n() const {
    return (rheobase_mv(neuron) - bias_mv) / drive_mv_per_n;
}

void DecodedAfferents::add(Address address, const Group& group, double share, std::uint32_t patch) {
    const auto same = std::find(groups.begin(), groups.end(), group);
    const auto index = static_cast<std::uint32_t>(same - groups.begin());
    if (same == groups.end()) groups.push_back(group);
    afferents.push_back({address, index, share, patch});
}

std::vector<bool> DecodedAfferents::read() const {
    std::vector<bool> read(addresses, false);
    for (const Afferent& afferent : afferents) read[afferent.address] = true;
    return read;
}

void DecodedAfferents::check() const {
    for (const Group& group : groups) {
        require(true, "drive_mv_per_n", "finite", group.drive_mv_per_n);
        require(true, "bias_mv", "finite", group.bias_mv);
        require(true, "drive_mv_s_per_n", "finite", group.drive_mv_s_per_n);
        if (!(group.full_scale_n > 0)) throw ParameterError("full_scale_n", "> 0", group.full_scale_n);
    }
    const Afferent* before = nullptr;
    for (const Afferent& afferent : afferents) {
        require(afferent.address < addresses, "address", "below the number of addresses", afferent.address);
        require(!before || afferent.address > before->address, "address", "increasing", afferent.address);
        require(afferent.group < groups.size(), "group", "one of the groups", afferent.group);
        require(afferent.share >= 0, "share", ">= 0", afferent.share);
        before = &afferent;
    }
    require(hysteresis >= 0 && hysteresis < 1, "hysteresis", ">= 0 and < 1", hysteresis);
    require(largest_grip_n >= 0, "largest_grip_n", ">= 0", largest_grip_n);
    require(uncertainty.gain >= 0, "uncertainty.gain", ">= 0", uncertainty.gain);
    require(uncertainty.common_gain >= 0, "uncertainty.common_gain", ">= 0", uncertainty.common_gain);
    require(uncertainty.share >= 0, "uncertainty.share", ">= 0", uncertainty.share);
    require(uncertainty.share_time_s > 0, "uncertainty.share_time_s", "> 0", uncertainty.share_time_s);
    require(uncertainty.offset_n >= 0, "uncertainty.offset_n", ">= 0", uncertainty.offset_n);
    require(uncertainty.hysteresis >= 0, "uncertainty.hysteresis", ">= 0", uncertainty.hysteresis);
    require(uncertainty.adaptation >= 0, "uncertainty.adaptation", ">= 0", uncertainty.adaptation);
}

}  // namespace afferent
