#include "afferent/scene/force_rate.hpp"

#include <algorithm>

namespace afferent {
namespace {

// The grip force at which the strongest loaded element of those read is at its full scale: curves end there.
double largest_grip_n(const Scene& scene) {
    double largest = 0;
    for (const Patch& patch : scene.patches())
        if (decodes(scene, patch))
            for (const double share : patch.share)
                if (share > 0)
                    largest = std::max(largest, scene.patches()[patch.reads].sensor.full_scale_n / share);
    return largest;
}

}  // namespace

bool decodes(const Scene& scene, const Patch& patch) {
    const auto& names = scene.description().decoder().patch();
    if (names.empty()) return patch.sustained();
    return std::find(names.begin(), names.end(), patch.name) != names.end();
}

DecodedAfferents decoded_afferents(const Scene& scene) {
    DecodedAfferents decoded{.addresses = scene.addresses(), .largest_grip_n = largest_grip_n(scene)};
    for (const Patch& patch : scene.patches()) {
        if (!decodes(scene, patch)) continue;
        for (std::uint32_t i = 0; i < patch.elements; ++i)
            decoded.add(patch.first + i, {patch.neuron, patch.gain() * patch.share[i], patch.bias_mv()},
                        patch.share[i]);
    }
    return decoded;
}

DecoderParameters decoder_parameters(const proto::Decoder& decoder) {
    return SlidingWindow::Parameters{
        .window = from_milliseconds(decoder.window_ms()),
        .curve = decoder.curve() == proto::ONSET ? RateKind::onset : RateKind::steady,
        .pooling = decoder.pooling() == proto::POOLED ? Pooling::pooled : Pooling::per_neuron};
}

std::vector<bool> read_addresses(const Scene& scene) { return decoded_afferents(scene).read(); }

GripEstimator make_estimator(const Scene& scene) {
    const auto window =
        std::get<SlidingWindow::Parameters>(decoder_parameters(scene.description().decoder()));
    return GripEstimator::of(decoded_afferents(scene), window.curve, window.pooling);
}

}  // namespace afferent
