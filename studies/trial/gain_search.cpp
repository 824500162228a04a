#include "afferent/studies/trial/gain_search.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "afferent/studies/trial/condition.hpp"
#include "afferent/studies/trial/stoppable_experiments.hpp"

namespace afferent {
namespace {

// As parts of the gain's limit, at which the hand closes no further.
constexpr std::array onsets{0.0, 0.1, 0.2, 0.35, 0.5};
constexpr std::array lambdas{0.1, 0.3, 0.8};
constexpr std::array bounds_sigmas{0.0, 1.0};
constexpr std::array leads_ms{0.0, 100.0, 200.0, 400.0};

// The search goes in rounds, each with more presentations and fewer gains than the one before:
// `presentations` is the part of GainSearch::presentations that every gain has had by the end of the round,
// and `kept` the part of the gains that goes on to the next, but at least `least_kept` of them.
struct Round {
    double presentations, kept;
};
constexpr std::array rounds{Round{1.0 / 16, 0.25}, Round{0.25, 0.25}, Round{1, 1}};
constexpr std::size_t least_kept = 6;

struct Candidate {
    scene::Gain gain;
    std::vector<Presentation> presentations = {};
    Tallies tallies = {};

    std::uint64_t lost() const { return tallies.delicate.failed().hits; }
    std::uint64_t dropped() const { return tallies.slippery.dropped().hits; }
};

bool beats(const Candidate& one, const Candidate& other) {
    return one.lost() <= other.lost() && one.dropped() <= other.dropped() &&
           (one.lost() < other.lost() || one.dropped() < other.dropped());
}

// Moves those that none of the others beats out of `all`.
std::vector<Candidate> take_front(std::vector<Candidate>& all) {
    const auto is_beaten = [&](const Candidate& one) {
        return std::ranges::any_of(all, [&](const Candidate& other) { return beats(other, one); });
    };
    std::vector<bool> beaten;
    for (const Candidate& one : all) beaten.push_back(is_beaten(one));
    std::vector<Candidate> front, rest;
    for (std::size_t i = 0; i < all.size(); ++i) (beaten[i] ? rest : front).push_back(std::move(all[i]));
    all = std::move(rest);
    return front;
}

// Evenly spread over what drops, and the ends among them. Few presentations cannot tell many gains apart.
std::vector<Candidate> thinned(std::vector<Candidate> front, std::size_t most) {
    if (front.size() <= most) return front;
    std::ranges::stable_sort(front, std::greater<>(), &Candidate::dropped);
    std::vector<Candidate> kept;
    for (std::size_t i = 0; i < most; ++i)
        kept.push_back(std::move(front[most == 1 ? 0 : i * (front.size() - 1) / (most - 1)]));
    return kept;
}

// The front, the front of what is then left, and so on, until there are so many.
std::vector<Candidate> best_of(std::vector<Candidate> all, std::size_t count) {
    std::vector<Candidate> best;
    while (best.size() < count && !all.empty())
        for (Candidate& one : thinned(take_front(all), count - best.size())) best.push_back(std::move(one));
    return best;
}

Scene with_gain(Scene scene, const std::string& condition, const scene::Gain& gain) {
    scene.trial->conditions = {{condition, gain}};
    return scene;
}

std::uint32_t part_of(std::uint32_t presentations, double part) {
    return std::max(1U, static_cast<std::uint32_t>(part * presentations));
}

// How many presentations a condition takes at most.
double effort_of(std::size_t candidates, std::uint32_t presentations) {
    double all = 0, done = 0;
    double left = static_cast<double>(candidates);
    for (const Round& round : rounds) {
        all += left * (round.presentations - done) * presentations;
        done = round.presentations;
        left = std::max(left * round.kept, static_cast<double>(least_kept));
    }
    return all + left * presentations;
}

// The gains are in the order of what drops: the more drops, the fewer break.
void choose(GainFront& front, double most_dropped) {
    const auto is_allowed = [&](const GainTrial& one) {
        const Proportion dropped = one.searched.slippery.dropped();
        return static_cast<double>(dropped.hits) <= most_dropped * static_cast<double>(dropped.of);
    };
    const auto found = std::ranges::find_if(front.gains, is_allowed);
    front.is_allowed = found != front.gains.end();
    front.chosen = static_cast<std::size_t>(found - front.gains.begin()) - (front.is_allowed ? 0 : 1);
}

void require_both_objects(const Scene& scene) {
    if (!scene.trial)
        throw SceneError({scene.file + ": has no trial { ... }; examples/trial_in_hand.txtpb has one"});
    const double part = scene.trial->slippery.part;
    if (!(part > 0 && part < 1))
        throw SceneError({scene.file + ": trial.slippery.part must be > 0 and < 1: among objects of one kind "
                                       "the best gain is that of a hand which always closes, or never"});
}

GainFront search_condition(const Scene& scene, const GainSearch& search, const std::string& condition,
                           StoppableExperiments& experiments) {
    std::vector<Candidate> left;
    for (const scene::Gain& gain : candidate_gains(scene, condition)) left.push_back({gain});
    std::uint32_t done = 0;
    for (const Round& round : rounds) {
        const std::uint32_t until = std::max(part_of(search.presentations, round.presentations), done);
        for (Candidate& one : left) {
            auto more =
                experiments.present(with_gain(scene, condition, one.gain), condition, done, until - done);
            if (experiments.is_stopped()) return {condition, {}};
            one.presentations.insert(one.presentations.end(), more.begin(), more.end());
            one.tallies = tally(one.presentations);
        }
        done = until;
        const auto least = static_cast<std::size_t>(round.kept * static_cast<double>(left.size()));
        left = best_of(std::move(left), std::max(least, least_kept));
    }
    left = take_front(left);
    std::ranges::stable_sort(left, std::greater<>(), &Candidate::dropped);

    GainFront front{condition, {}};
    for (Candidate& one : left) {
        if (!front.gains.empty() && one.dropped() == front.gains.back().searched.slippery.dropped().hits)
            continue;  // and as many are lost with it
        Scene other = with_gain(scene, condition, one.gain);
        other.seed = search.held_out_seed;
        auto held_out = experiments.present(other, condition, 0, search.presentations);
        if (experiments.is_stopped()) return {condition, {}};
        front.gains.push_back({one.gain, one.tallies, std::move(held_out)});
    }
    choose(front, search.most_dropped);
    return front;
}

}  // namespace

std::vector<scene::Gain> candidate_gains(const Scene& scene, const std::string& condition) {
    const Condition& of = afferent::condition(condition);
    const Scene own = of.applied_to(scene);
    const bool has_sigma = of.feed == Condition::Feed::events;
    const bool knows_speed = has_sigma && is_filter(own.decoder);
    std::vector<scene::Gain> gains{own.gain};
    for (const double onset : onsets)
        for (const double lambda : lambdas)
            for (const double sigmas : bounds_sigmas)
                for (const double lead_ms : leads_ms) {
                    if ((sigmas > 0 && !has_sigma) || (lead_ms > 0 && !knows_speed)) continue;
                    scene::Gain gain = own.gain;
                    gain.onset_n = onset * gain.limit_n;
                    gain.lambda_n = lambda * gain.limit_n;
                    gain.upper_bound_sigmas = sigmas;
                    gain.lead_ms = lead_ms;
                    if (std::ranges::find(gains, gain) == gains.end()) gains.push_back(gain);
                }
    return gains;
}

std::vector<GainFront> search_gains(const Scene& scene, const GainSearch& search) {
    require_both_objects(scene);
    double all = 0;
    for (const std::string& each : search.conditions) {
        if (condition(each).feed == Condition::Feed::nothing)
            throw SceneError({"condition: " + each + " has no feedback that a gain could go by"});
        all += effort_of(candidate_gains(scene, each).size(), search.presentations);
    }
    StoppableExperiments experiments(search.progress, all);
    std::vector<GainFront> fronts;
    for (const std::string& each : search.conditions) {
        GainFront front = search_condition(scene, search, each, experiments);
        if (experiments.is_stopped()) break;
        fronts.push_back(std::move(front));
    }
    return fronts;
}

}  // namespace afferent
