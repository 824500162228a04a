// How a presentation ends.
#pragma once

namespace afferent {

// An object that was never gripped, or that slipped out of the fingers, is dropped.
enum class Outcome { held, broken, dropped };

constexpr const char* name(Outcome outcome) noexcept {
    return outcome == Outcome::held ? "held" : outcome == Outcome::broken ? "broken" : "dropped";
}

}  // namespace afferent
