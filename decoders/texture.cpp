#include "afferent/decoders/texture.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

std::vector<SkinField> fields_of(const std::vector<TextureReadout::Afferent>& afferents) {
    std::vector<SkinField> fields;
    for (const TextureReadout::Afferent& afferent : afferents) fields.push_back(afferent.field);
    return fields;
}

}  // namespace

TextureReadout::TextureReadout(const Parameters& parameters)
    : patch_(parameters.patch),
      index_of_(parameters.addresses, not_read),
      wave_(fields_of(parameters.afferents), parameters.window),
      variation_(fields_of(parameters.afferents), parameters.window),
      trains_(parameters.afferents.size(), parameters.window),
      ended_{.trains = trains_} {
    std::uint32_t index = 0;
    for (const Afferent& afferent : parameters.afferents) {
        require(afferent.address < parameters.addresses, "afferents", "of the stream", afferent.address);
        index_of_[afferent.address] = index++;
    }
    restart(scene_start);
}

TimePoint TextureReadout::window_at(TimePoint time) const noexcept {
    return scene_start + (time - scene_start) / trains_.window() * trains_.window();
}

void TextureReadout::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    lose(progress_.heard_until, begin);
    // A window ends once no part of its last span comes any more.
    if (begin >= progress_.heard_until) reach(begin);
    for (const Event& event : events) {
        const std::uint32_t index = index_of_[event.address];
        if (index == not_read) continue;
        if (event.time >= window_end()) reach(event.time);
        if (event.time < progress_.begin) continue;
        const auto time_ns = static_cast<std::uint32_t>((event.time - progress_.begin).count());
        progress_.dropped += !trains_.add(index, time_ns);
    }
    progress_.heard_until = std::max(progress_.heard_until, end);
}

void TextureReadout::reach(TimePoint time) noexcept {
    if (time < window_end()) return;
    end_window();
    trains_.clear();
    progress_.begin = window_at(time);
    progress_.lost = {};
}

void TextureReadout::end_window() noexcept {
    advance(std::numeric_limits<std::size_t>::max());
    if (2 * progress_.lost > trains_.window()) return;
    std::swap(trains_, ended_.trains);
    begin_fit(window_end());
}

void TextureReadout::begin_fit(TimePoint window_end) noexcept {
    ended_.end = window_end;
    ended_.steps = 0;
    ended_.trains.sort();
    fitted_ = PatchTexture{.end = window_end, .patch = patch_};
    for (std::size_t i = 0; i < ended_.trains.afferents(); ++i) {
        const auto events = static_cast<std::uint32_t>(ended_.trains.of(i).size());
        fitted_.events += events;
        fitted_.afferents += events > 0;
    }
    wave_.begin();
    variation_.begin();
    fitting_ = true;
}

void TextureReadout::advance(std::size_t work) noexcept {
    if (!fitting_) return;
    ++ended_.steps;
    WorkBudget budget(work);
    fitting_ = !wave_.advance(ended_.trains, budget, fitted_.estimate) ||
               !variation_.advance(ended_.trains, budget, fitted_.estimate);
    if (fitting_) return;
    progress_.dropped += told_.has_value();
    told_ = fitted_;
}

void TextureReadout::lose(TimePoint begin, TimePoint end) noexcept {
    begin = std::max(begin, progress_.heard_until);
    if (begin >= end) return;
    progress_.lost += std::max(Duration(0), std::min(end, window_end()) - begin);
    reach(end);
    // A window that the loss has reached into.
    if (progress_.begin > begin) progress_.lost = end - progress_.begin;
    progress_.heard_until = end;
}

void TextureReadout::restart(TimePoint start) noexcept {
    const std::uint64_t dropped = progress_.dropped;
    progress_ = {.begin = window_at(start), .heard_until = start, .dropped = dropped};
    progress_.lost = start - progress_.begin;
    trains_.clear();
    fitting_ = false;
    told_.reset();
}

std::optional<PatchTexture> TextureReadout::step(TimePoint) noexcept {
    if (!told_) advance(work_a_step);
    return std::exchange(told_, std::nullopt);
}

TextureReadout::Snapshot TextureReadout::snapshot() const {
    return {progress_, trains_, told_, fitting_ ? std::optional(ended_) : std::nullopt};
}

bool TextureReadout::same_windows(const SpikeTrains& trains) const noexcept {
    return trains.afferents() == trains_.afferents() && trains.window() == trains_.window();
}

void TextureReadout::resume(const Snapshot& snapshot) {
    require(same_windows(snapshot.trains) && (!snapshot.ended || same_windows(snapshot.ended->trains)),
            "snapshot.trains", "of the same afferents and windows",
            static_cast<double>(snapshot.trains.afferents()));
    progress_ = snapshot.progress;
    trains_ = snapshot.trains;
    fitting_ = false;
    told_ = snapshot.told;
    if (!snapshot.ended) return;
    ended_.trains = snapshot.ended->trains;
    begin_fit(snapshot.ended->end);
    while (fitting_ && ended_.steps < snapshot.ended->steps) advance(work_a_step);
}

std::size_t TextureReadout::bytes() const noexcept {
    return sizeof *this + index_of_.capacity() * sizeof(std::uint32_t) + wave_.heap_bytes() +
           variation_.heap_bytes() + trains_.heap_bytes() + ended_.trains.heap_bytes();
}

}  // namespace afferent
