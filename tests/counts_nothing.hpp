// That a count begins at 0.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <type_traits>

namespace afferent {

// Whether the members of new Counts, all of which are whole numbers of eight bytes, are 0.
template <class Counts>
bool counts_nothing() {
    static_assert(std::has_unique_object_representations_v<Counts>);
    const auto all = std::bit_cast<std::array<std::uint64_t, sizeof(Counts) / 8>>(Counts());
    return std::ranges::count(all, 0U) == std::ssize(all);
}

}  // namespace afferent
