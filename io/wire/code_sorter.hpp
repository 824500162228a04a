// Sorts the codes of a packet, whose events come sorted by time, but within a tick in any order of addresses;
// and the events of a window.
#pragma once

#include <memory>
#include <span>

#include "afferent/io/wire/payload.hpp"
#include "afferent/runtime/event_key.hpp"

namespace afferent {

// Vectorised quicksort (Blacher et al., arXiv:2205.05982), about as fast as two passes over the codes;
// std::sort would take ten times as long as the coding. Allocates at construction only.
class CodeSorter {
  public:
    CodeSorter();
    ~CodeSorter();
    CodeSorter(CodeSorter&&) noexcept;
    CodeSorter& operator=(CodeSorter&&) noexcept;

    void sort(std::span<Code> codes) const;
    void sort(std::span<EventKey> keys) const;

  private:
    class Sorter;
    std::unique_ptr<Sorter> sorter_;
};

}  // namespace afferent
