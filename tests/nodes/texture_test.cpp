// What a fingertip tells of gratings and textures that slide over it. `build/release/tests/nodes_tests
// --gtest_filter='Textures*'` prints the figures of docs/readouts.md.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "tests/long_runs.hpp"
#include "tests/nodes/whole_run.hpp"

namespace afferent {
namespace {

enum Patch { sa1, ra };

// The pad covers the tip of examples/fingertip.txtpb.
SurfacePad pad_of_the_tip() { return {.width_mm = 15, .height_mm = 9, .peak_kpa = 20}; }

Scene fingertip_on(scene::Touch touch, std::uint64_t seed) {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/fingertip.txtpb");
    std::erase_if(scene.patches, [](const auto& patch) { return patch.name == "PC"; });
    scene.source = std::move(touch);
    scene.duration_s = 1.6;
    scene.seed = seed;
    scene.record = {.events = true, .force = false, .picture = false};
    scene.decoder.kind = scene::Filter();  // which is planned faster than curves of rates
    scene.decoder.texture.emplace();
    return scene;
}

}  // namespace
}  // namespace afferent
