// What is said about tables that do not fit their scene.
#pragma once

#include <array>
#include <cstdio>
#include <string>

#include "afferent/runtime/time.hpp"

namespace afferent {

// A table that ends this much before its scene has not ended early.
inline constexpr Duration table_end_tolerance = 100ms;

inline std::string in_seconds(Duration time) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.15g s", seconds(time));
    return text.data();
}

}  // namespace afferent
