// Which gain suits a condition: those that no other beats both in what breaks and in what drops.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"
#include "afferent/studies/trial/presentation.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {

struct GainSearch {
    // With feedback.
    std::vector<std::string> conditions;
    // How often each gain of the last round is presented: once with the scene's seed, on which it is chosen,
    // and the gains of the front once more with held_out_seed, on which nothing is chosen.
    std::uint32_t presentations;
    std::uint64_t held_out_seed;
    // The chosen gain drops at most this part of the heavy objects.
    double most_dropped;
    // Called with the share that is done, every so often; false stops.
    std::function<bool(double share)> progress = {};
};

struct GainTrial {
    scene::Gain gain;
    Tallies searched;
    std::vector<Presentation> held_out;
};

// The gains of one condition, with ever fewer heavy objects dropped and more delicate ones broken.
struct GainFront {
    std::string condition;
    std::vector<GainTrial> gains;  // never empty
    // As searched: among the gains that drop no more than allowed, the one that breaks the fewest. If there
    // is none, the one that drops the fewest, and is_allowed is false.
    std::size_t chosen = 0;
    bool is_allowed = false;
};

// What is tried for a condition: onset, lambda, bound and, with the filter, lead; the scene's own gain first,
// with its brake and its limit.
std::vector<scene::Gain> candidate_gains(const Scene& scene, const std::string& condition);

// A front for each condition; those that were found when it was stopped. Throws SceneError, as Experiment
// does, and where the scene has no objects of both kinds, or a condition no feedback.
std::vector<GainFront> search_gains(const Scene& scene, const GainSearch& search);

}  // namespace afferent
