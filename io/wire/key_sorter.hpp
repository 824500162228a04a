// Sorts the keys of a packet: by time they come sorted, within a tick by no means.
#pragma once

#include <memory>
#include <span>

#include "afferent/io/wire/payload.hpp"

namespace afferent {

// Vectorised quicksort (Blacher et al., arXiv:2205.05982), as good as two passes over the keys; std::sort
// would take ten times as long as the coding. Allocates at construction only.
class KeySorter {
  public:
    KeySorter();
    ~KeySorter();
    KeySorter(KeySorter&&) noexcept;
    KeySorter& operator=(KeySorter&&) noexcept;

    void sort(std::span<Key> keys) const;

  private:
    class Sorter;
    std::unique_ptr<Sorter> sorter_;
};

}  // namespace afferent
