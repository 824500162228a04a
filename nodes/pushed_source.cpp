#include "afferent/nodes/pushed_source.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

Error refused(const std::string& what) { return {Error::Kind::malformed, "a pushed scan " + what}; }

}  // namespace

PushedSource::PushedSource(const Plan& plan, std::size_t capacity)
    : SampleSource(plan), waiting_(std::max<std::size_t>(1, capacity)), held_n_(plan.patches.size()) {
    for (const std::size_t owner : owners()) held_n_[owner].resize(plan.patches[owner].elements());
}

Result<void> PushedSource::push(const Scan& scan) {
    const std::vector<PatchPlan>& patches = plan().patches;
    const auto owner = std::find_if(owners().begin(), owners().end(), [&](std::size_t patch) {
        return patches[patch].first_element == scan.first;
    });
    if (owner == owners().end())
        return refused("begins at element " + std::to_string(scan.first) + ", where no patch begins");
    if (scan.forces_n.size() != patches[*owner].elements())
        return refused("has " + std::to_string(scan.forces_n.size()) + " forces; patch \"" +
                       patches[*owner].name + "\" has " + std::to_string(patches[*owner].elements()) +
                       " elements");
    if (scan.time < last_)
        return refused("is of " + std::to_string(seconds(scan.time)) + " s, and one of " +
                       std::to_string(seconds(last_)) + " s has come before it");
    last_ = scan.time;
    if (count_ == waiting_.size()) {
        first_ = (first_ + 1) % waiting_.size();
        --count_;
        ++dropped_;
    }
    std::vector<double>& held_n = held_n_[*owner];
    std::transform(scan.forces_n.begin(), scan.forces_n.end(), held_n.begin(), held_n.begin(),
                   [](double force_n, double held) { return std::isfinite(force_n) ? force_n : held; });
    Waiting& waiting = waiting_[(first_ + count_++) % waiting_.size()];
    waiting.due = {scan.time, Kind::scan, static_cast<Address>(*owner)};
    waiting.forces_n.assign(held_n.begin(), held_n.end());
    return success();
}

std::optional<Due> PushedSource::next() {
    if (count_ == 0) return std::nullopt;
    return waiting_[first_].due;
}

std::optional<Scan> PushedSource::take(double) {
    const Waiting& waiting = waiting_[first_];
    first_ = (first_ + 1) % waiting_.size();
    --count_;
    const Address patch = waiting.due.address;
    return Scan{waiting.due.time, plan().patches[patch].first_element,
                sensors(patch).take_newtons(waiting.forces_n)};
}

}  // namespace afferent
