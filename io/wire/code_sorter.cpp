#include "afferent/io/wire/code_sorter.hpp"

#include <hwy/contrib/sort/vqsort.h>

#include <algorithm>

namespace afferent {

class CodeSorter::Sorter : public hwy::Sorter {};

CodeSorter::CodeSorter() : sorter_(std::make_unique<Sorter>()) {}
CodeSorter::~CodeSorter() = default;
CodeSorter::CodeSorter(CodeSorter&&) noexcept = default;
CodeSorter& CodeSorter::operator=(CodeSorter&&) noexcept = default;

namespace {

template <class Number>
void sort_by(const hwy::Sorter& sorter, std::span<Number> numbers) {
    if (std::is_sorted(numbers.begin(), numbers.end())) return;
    sorter(numbers.data(), numbers.size(), hwy::SortAscending());
}

}  // namespace

void CodeSorter::sort(std::span<Code> codes) const { sort_by(*sorter_, codes); }
void CodeSorter::sort(std::span<EventKey> keys) const { sort_by(*sorter_, keys); }

}  // namespace afferent
