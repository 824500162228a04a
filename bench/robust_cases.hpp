// What a decoder may not be told: the cases of `bench decoding --not-as-told`, in one list.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/decoders/uncertainty.hpp"
#include "bench/robust_world.hpp"

namespace afferent {

// The grips from which cases are made.
struct RobustInput {
    Scene grasp, paper;
    GripForce grasped_n;                   // in the grasp's own run
    std::vector<RecordedForces> recorded;  // may be empty
};
// Throws SceneError or std::runtime_error.
RobustInput robust_input(const std::filesystem::path& examples, const std::filesystem::path& data);

struct RobustCase {
    std::string name;
    std::string wrong;  // in words
    // The grips, each with a right description. Neighbours with the same name are pooled into one row.
    std::function<std::vector<World>(const RobustInput&)> worlds;
    // Makes the description wrong. Draws are numbered from 0.
    std::function<void(World& world, unsigned draw)> change;
    unsigned draws = 1;
    // The true size of the error, for a second run in which the decoder knows it.
    std::optional<Uncertainty> stated = {};
    bool quick = false;  // belongs to the subset of --quick
};

const std::vector<RobustCase>& robust_cases();

}  // namespace afferent
