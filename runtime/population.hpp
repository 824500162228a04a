// Who the afferents of a scene are: what each address stands for.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/position.hpp"

namespace afferent {

struct Population {
    struct Patch {
        std::string name = {};
        std::uint32_t afferents = 0;  // with the addresses that follow those of the patch before
        std::string kind = {};        // "SA1", or "sustained"; empty: not known
        bool operator==(const Patch&) const = default;
    };
    struct Afferent {
        std::optional<Position> place = {};  // none: its patch has no dimensions
        Address element = 0;                 // the one that it reads most, among all elements of the scene
        std::uint32_t elements = 1;          // how many it reads
        bool operator==(const Afferent&) const = default;
    };

    std::vector<Patch> patches = {};       // from address 0 on; none: not known
    std::vector<Afferent> afferents = {};  // of all patches, by address; none: not known
    bool operator==(const Population&) const = default;

    // The number of afferents of all patches.
    std::uint64_t size() const noexcept {
        std::uint64_t sum = 0;
        for (const Patch& patch : patches) sum += patch.afferents;
        return sum;
    }
    bool has_positions() const noexcept {
        return std::ranges::any_of(afferents, [](const Afferent& each) { return each.place.has_value(); });
    }
    bool has_kinds() const noexcept {
        return std::ranges::any_of(patches, [](const Patch& each) { return !each.kind.empty(); });
    }
};

}  // namespace afferent
