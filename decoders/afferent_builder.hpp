// Adds many afferents to what a decoder is told.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "afferent/decoders/decoded_afferents.hpp"

namespace afferent {

// Does what DecodedAfferents::add does, in constant time for each afferent however many groups there are.
class AfferentBuilder {
  public:
    // Appends to `afferents`, which nothing else changes meanwhile.
    explicit AfferentBuilder(DecodedAfferents& afferents);

    void add(Address address, const DecodedAfferents::Group& group, double share, std::uint32_t patch = 0);

  private:
    std::uint32_t index_of(const DecodedAfferents::Group& group);

    DecodedAfferents& afferents_;
    // From a hash of a group's drive to the indices of the groups that have it.
    std::unordered_multimap<std::size_t, std::uint32_t> groups_;
};

}  // namespace afferent
