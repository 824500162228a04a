// Fits a scene to recordings: gains, biases and shares to forces and spikes, and the filter's noise to forces
// alone.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/decoders/afferent_fit.hpp"
#include "afferent/decoders/motion_fit.hpp"
#include "afferent/io/files/table.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// How elements' shares of the grip force wander about constant ones. Elements are weighted by their shares,
// and rows count where the grip is above a tenth of its largest.
struct ShareWander {
    double part;    // standard deviation, as a part of the share
    double time_s;  // the lag at which its autocorrelation has fallen to 1/e
};

struct SceneFit {
    Scene scene;  // with what was found

    struct Element {
        std::string patch;
        std::uint32_t element;
        // The element's share of the grip force, or of the sum of all forces where the table has a column for
        // each element.
        std::optional<double> share;
        // The residual of its force after subtracting its share of the grip, root mean square.
        std::optional<double> share_residual_n;
        // Its column never changes: a dead sensor, which is left out.
        bool dead = false;
    };
    std::vector<Element> elements;  // where there is anything to tell of their shares

    struct Afferent {
        Address address;
        std::optional<DriveFit> fit;  // to the force that it felt, or to the grip force; none: too few spikes
    };
    struct Patch {
        std::size_t index;
        // Fitted to all afferents together, over the force that each felt.
        std::optional<DriveFit> fit;
        std::vector<Afferent> afferents;
        std::vector<DriveSample> samples;
    };
    std::vector<Patch> patches;  // with sustained encoders; none without spikes

    std::optional<MotionFit> motions;

    // How far elements are from their shares and gains; none: not known. The scene's `uncertainty` has it.
    std::optional<ShareWander> shares_wander;
    std::optional<double> gain_spread;
};

// The table has one column with the grip force in newtons, or a column for each element, in newtons or in
// counts or volts, which go through the curve of the scene's sensors; `unit` is that of columns whose names
// have none. Events are sorted; none: there are forces alone.
//
// With a column for each element, the shares that fit best are those of the sum of all columns. With spikes,
// gain and bias of each patch are fitted as well. From spikes and a grip force alone only the product of gain
// and share is known: where the scene gives a patch shares, they are refitted and keep their sum; the patches
// without shares get one common gain, and divide the rest of the grip. Elements whose afferents do not fire
// keep the shares that they had.
//
// A column that never changes is of a dead sensor: it has no share, and reads 0. How far the others wander
// from their shares is written as well, and with spikes how much the gains of afferents differ within their
// patches.
//
// `malformed`: columns or addresses are not the scene's. Throws SceneError.
Result<SceneFit> calibrate(const Scene& scene, const Table& forces, std::span<const Event> events,
                           scene::TableUnit unit = scene::TableUnit::by_name);

}  // namespace afferent
