#include "afferent/studies/trial/sample_radio.hpp"

#include <algorithm>
#include <utility>

#include "afferent/hand/random.hpp"

namespace afferent {

SampleRadio::SampleRadio(Duration interval, std::uint32_t elements, std::uint64_t seed)
    : interval_(interval),
      seed_(seed),
      newest_n_(elements),
      under_way_n_(elements),
      handed_over_n_(elements) {}

void SampleRadio::begin(std::uint32_t number) {
    next_ = scene_start + rounded(Interval(uniform(seed_, Stream::trial_radio, number, 0) *
                                           static_cast<double>(interval_.count())));
    std::fill(newest_n_.begin(), newest_n_.end(), 0);
    has_newest_ = has_under_way_ = false;
}

void SampleRadio::take(Address first, std::span<const double> forces_n) {
    std::copy(forces_n.begin(), forces_n.end(), newest_n_.begin() + first);
    has_newest_ = true;
}

std::optional<std::span<const double>> SampleRadio::connect() {
    next_ += interval_;
    std::swap(handed_over_n_, under_way_n_);
    const bool handed_over = std::exchange(has_under_way_, std::exchange(has_newest_, false));
    under_way_n_ = newest_n_;
    if (!handed_over) return std::nullopt;
    return handed_over_n_;
}

}  // namespace afferent
