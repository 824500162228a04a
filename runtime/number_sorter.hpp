// Sorts the keys of a window's events, and the codes of a packet's.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

namespace afferent {

// Vectorised quicksort (Blacher et al., arXiv:2205.05982), about as fast as two passes over the codes;
// std::sort would take ten times as long as coding a packet. What is sorted already costs one look. Allocates
// at construction only.
class NumberSorter {
  public:
    NumberSorter();
    ~NumberSorter();
    // Nothing is kept from one call to the next: a copy is another sorter.
    NumberSorter(const NumberSorter&) : NumberSorter() {}
    NumberSorter& operator=(const NumberSorter&) noexcept { return *this; }
    NumberSorter(NumberSorter&&) noexcept;
    NumberSorter& operator=(NumberSorter&&) noexcept;

    void sort(std::span<std::uint32_t> numbers) const;
    void sort(std::span<std::uint64_t> numbers) const;

  private:
    class Sorter;
    std::unique_ptr<Sorter> sorter_;
};

}  // namespace afferent
