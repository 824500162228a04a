#include "afferent/decoders/edge.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

std::vector<EdgeFit::Afferent> fitted_of(const std::vector<EdgeReadout::Afferent>& afferents) {
    std::vector<EdgeFit::Afferent> fitted;
    for (const EdgeReadout::Afferent& afferent : afferents) fitted.push_back(afferent.fitted);
    return fitted;
}

}  // namespace

EdgeReadout::EdgeReadout(const Parameters& parameters)
    : settle_(parameters.settle),
      patch_(parameters.patch),
      fit_(fitted_of(parameters.afferents)),
      index_of_(parameters.addresses, not_read),
      has_fired_(parameters.afferents.size()) {
    require(settle_ > 0ns, "settle", "> 0", seconds(settle_));
    std::uint32_t index = 0;
    for (const Afferent& afferent : parameters.afferents) {
        require(afferent.address < parameters.addresses, "afferents", "of the stream", afferent.address);
        index_of_[afferent.address] = index++;
    }
    firsts_.reserve(parameters.afferents.size());
    touches_.reserve(most_untaken);
    restart(scene_start);
}

void EdgeReadout::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > progress_.heard_until) lose(progress_.heard_until, begin);
    // Silence up to the end of a span is known once no part of it comes any more.
    if (begin >= progress_.heard_until) wait(begin);
    for (const Event& event : events) {
        const std::uint32_t index = index_of_[event.address];
        // A part of an earlier span that comes later may have events before the last.
        if (index == not_read || event.time < progress_.last) continue;
        wait(event.time);
        progress_.last = event.time;
        if (progress_.silent) {
            progress_.silent = false;
            progress_.open = true;
            progress_.begin = event.time;
            firsts_.clear();
            std::fill(has_fired_.begin(), has_fired_.end(), false);
        }
        if (!progress_.open || has_fired_[index]) continue;
        has_fired_[index] = true;
        firsts_.push_back({index, seconds(event.time - progress_.begin)});
        progress_.last_first = event.time;
    }
    progress_.heard_until = std::max(progress_.heard_until, end);
}

void EdgeReadout::wait(TimePoint until) noexcept {
    if (progress_.open && until - progress_.last_first >= settle_) tell(progress_.last_first + settle_);
    if (!progress_.open && until - progress_.last >= settle_) progress_.silent = true;
}

void EdgeReadout::tell(TimePoint now) noexcept {
    progress_.open = false;
    if (firsts_.size() < EdgeFit::fewest) return;
    if (touches_.size() == most_untaken) {
        touches_.erase(touches_.begin());
        ++progress_.dropped;
    }
    touches_.push_back({.begin = progress_.begin,
                        .patch = patch_,
                        .told = now,
                        .afferents = static_cast<std::uint32_t>(firsts_.size()),
                        .edge = fit_(firsts_)});
}

void EdgeReadout::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    if (progress_.open) tell(std::max(begin, progress_.last_first));
    progress_.silent = false;
    progress_.last = std::max(progress_.last, end);
}

void EdgeReadout::restart(TimePoint start) noexcept {
    const std::uint64_t dropped = progress_.dropped;
    progress_ = {};
    // A scene begins untouched.
    progress_.silent = start == scene_start;
    progress_.last = progress_.heard_until = start;
    progress_.dropped = dropped;
    firsts_.clear();
    touches_.clear();
}

std::optional<EdgeTouch> EdgeReadout::step(TimePoint) {
    if (touches_.empty()) return std::nullopt;
    const EdgeTouch oldest = touches_.front();
    take();
    return oldest;
}

EdgeReadout::Snapshot EdgeReadout::snapshot() const { return {progress_, firsts_, touches_}; }

void EdgeReadout::resume(const Snapshot& snapshot) {
    require(snapshot.firsts.size() <= has_fired_.size(), "snapshot.firsts",
            "of no more afferents than there are", static_cast<double>(snapshot.firsts.size()));
    for (const EdgeFit::First& first : snapshot.firsts)
        require(first.afferent < has_fired_.size(), "snapshot.firsts", "of the same afferents",
                first.afferent);
    progress_ = snapshot.progress;
    firsts_.assign(snapshot.firsts.begin(), snapshot.firsts.end());
    touches_.assign(snapshot.touches.begin(), snapshot.touches.end());
    std::fill(has_fired_.begin(), has_fired_.end(), false);
    for (const EdgeFit::First& first : firsts_) has_fired_[first.afferent] = true;
}

std::size_t EdgeReadout::bytes() const noexcept {
    return sizeof *this + fit_.heap_bytes() + index_of_.capacity() * sizeof(std::uint32_t) +
           has_fired_.capacity() / 8 + firsts_.capacity() * sizeof(EdgeFit::First) +
           touches_.capacity() * sizeof(EdgeTouch);
}

}  // namespace afferent
