#include "afferent/studies/trial/felt_shares.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "afferent/hand/random.hpp"

namespace afferent {

std::vector<double> felt_shares(const scene::TrialSensing& sensing, std::vector<double> stated,
                                std::uint64_t seed, std::uint32_t number) {
    std::vector<double> felt = std::move(stated);
    const auto factor = [&](double spread, Stream stream, std::size_t element) {
        return std::exp(spread * gaussian(seed, stream, static_cast<std::uint32_t>(element), number));
    };
    const auto sum = [&] { return std::accumulate(felt.begin(), felt.end(), 0.0); };
    if (sensing.share_spread > 0) {
        const double whole = sum();
        for (std::size_t i = 0; i < felt.size(); ++i)
            felt[i] *= factor(sensing.share_spread, Stream::trial_share, i);
        const double scale = whole / sum();
        for (double& each : felt) each *= scale;
    }
    const double common = factor(sensing.common_gain_spread, Stream::trial_common_gain, 0);
    for (std::size_t i = 0; i < felt.size(); ++i)
        felt[i] *= common * factor(sensing.gain_spread, Stream::trial_gain, i);
    // Each time one of those that are still alive.
    std::vector<std::size_t> alive(felt.size());
    std::iota(alive.begin(), alive.end(), std::size_t{0});
    for (std::uint32_t k = 0; k < sensing.dead_elements && !alive.empty(); ++k) {
        const double drawn = uniform(seed, Stream::trial_dead, k, number);
        const auto at = static_cast<std::size_t>(drawn * static_cast<double>(alive.size()));
        felt[alive[at]] = 0;
        alive.erase(alive.begin() + static_cast<std::ptrdiff_t>(at));
    }
    return felt;
}

}  // namespace afferent
