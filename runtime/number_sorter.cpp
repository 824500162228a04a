#include "afferent/runtime/number_sorter.hpp"

#include <hwy/contrib/sort/vqsort.h>

#include <algorithm>

namespace afferent {

class NumberSorter::Sorter : public hwy::Sorter {};

NumberSorter::NumberSorter() : sorter_(std::make_unique<Sorter>()) {}
NumberSorter::~NumberSorter() = default;
NumberSorter::NumberSorter(NumberSorter&&) noexcept = default;
NumberSorter& NumberSorter::operator=(NumberSorter&&) noexcept = default;

namespace {

template <class Number>
void sort_by(const hwy::Sorter& sorter, std::span<Number> numbers) {
    if (std::is_sorted(numbers.begin(), numbers.end())) return;
    sorter(numbers.data(), numbers.size(), hwy::SortAscending());
}

}  // namespace

void NumberSorter::sort(std::span<std::uint32_t> numbers) const { sort_by(*sorter_, numbers); }
void NumberSorter::sort(std::span<std::uint64_t> numbers) const { sort_by(*sorter_, numbers); }

}  // namespace afferent
