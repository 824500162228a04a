#include "afferent/io/wire/code_sorter.hpp"

#include <hwy/contrib/sort/vqsort.h>

#include <algorithm>

namespace afferent {

class CodeSorter::Sorter : public hwy::Sorter {};

CodeSorter::CodeSorter() : sorter_(std::make_unique<Sorter>()) {}
CodeSorter::~CodeSorter() = default;
CodeSorter::CodeSorter(CodeSorter&&) noexcept = default;
CodeSorter& CodeSorter::operator=(CodeSorter&&) noexcept = default;

void CodeSorter::sort(std::span<Code> codes) const {
    if (std::is_sorted(codes.begin(), codes.end())) return;
    (*sorter_)(codes.data(), codes.size(), hwy::SortAscending());
}

}  // namespace afferent
