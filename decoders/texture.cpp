#include "afferent/decoders/texture.hpp"

#include <algorithm>
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
      trains_(parameters.afferents.size(), parameters.window) {
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
    // A window is told once no part of its last span comes any more.
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
    tell();
    trains_.clear();
    progress_.begin = window_at(time);
    progress_.lost = {};
}

void TextureReadout::tell() noexcept {
    if (2 * progress_.lost > trains_.window()) return;
    progress_.dropped += told_.has_value();
    trains_.sort();
    told_ = PatchTexture{.end = window_end(), .patch = patch_};
    for (std::size_t i = 0; i < trains_.afferents(); ++i) {
        const auto events = static_cast<std::uint32_t>(trains_.of(i).size());
        told_->events += events;
        told_->afferents += events > 0;
    }
    wave_(trains_, told_->estimate);
    variation_(trains_, told_->estimate);
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
    told_.reset();
}

std::optional<PatchTexture> TextureReadout::step(TimePoint) noexcept {
    return std::exchange(told_, std::nullopt);
}

void TextureReadout::resume(const Snapshot& snapshot) {
    require(
        snapshot.trains.afferents() == trains_.afferents() && snapshot.trains.window() == trains_.window(),
        "snapshot.trains", "of the same afferents and windows",
        static_cast<double>(snapshot.trains.afferents()));
    progress_ = snapshot.progress;
    trains_ = snapshot.trains;
    told_ = snapshot.told;
}

std::size_t TextureReadout::bytes() const noexcept {
    return sizeof *this + index_of_.capacity() * sizeof(std::uint32_t) + wave_.heap_bytes() +
           variation_.heap_bytes() + trains_.heap_bytes();
}

}  // namespace afferent
