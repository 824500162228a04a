// Fits a scene to what was recorded: gains, biases and shares to forces and spikes, and the filter's noise to
// forces.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/decoders/afferent_fit.hpp"
#include "afferent/decoders/motion_fit.hpp"
#include "afferent/io/files/table.hpp"
#include "afferent/io/wire/result.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct SceneFit {
    Scene scene;  // with what was found

    struct Element {
        std::string patch;
        std::uint32_t element;
        // Of the grip force; the sum of all forces, where the table has a column for each element.
        std::optional<double> share;
        // What is left of its force without its share of the grip, root mean square.
        std::optional<double> share_residual_n;
    };
    std::vector<Element> elements;  // where there is anything to tell of their shares

    struct Afferent {
        Address address;
        std::optional<DriveFit> fit;  // to the force that it felt, or to the grip force; none: too few spikes
    };
    struct Patch {
        std::size_t index;
        // Of all afferents together, over the force that each felt.
        std::optional<DriveFit> fit;
        std::vector<Afferent> afferents;
        std::vector<DriveSample> samples;
    };
    std::vector<Patch> patches;  // with sustained encoders; none without spikes

    std::optional<MotionFit> motions;
};

// Forces in a column in newtons, the grip's, or in a column for each element, in newtons or in counts, which
// go through the curve of the scene's sensors. Events are sorted; none: forces alone.
//
// With a column for each element, the shares are those of the sum that fit best. With spikes, so are the gain
// and the bias of each patch. From spikes and a grip force alone only gain times share is known: where the
// scene gives a patch shares, they still add up to what they did; patches without have one gain, and share
// what is left of the grip. Elements whose afferents do not fire keep the shares that they had.
//
// `malformed`: columns or addresses are not the scene's. Throws SceneError.
Result<SceneFit> calibrate(const Scene& scene, const Table& forces, std::span<const Event> events);

}  // namespace afferent
