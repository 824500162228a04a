#include "afferent/io/wire/key_sorter.hpp"

#include <hwy/contrib/sort/vqsort.h>

#include <algorithm>

namespace afferent {

class KeySorter::Sorter : public hwy::Sorter {};

KeySorter::KeySorter() : sorter_(std::make_unique<Sorter>()) {}
KeySorter::~KeySorter() = default;
KeySorter::KeySorter(KeySorter&&) noexcept = default;
KeySorter& KeySorter::operator=(KeySorter&&) noexcept = default;

void KeySorter::sort(std::span<Key> keys) const {
    if (std::is_sorted(keys.begin(), keys.end())) return;
    (*sorter_)(keys.data(), keys.size(), hwy::SortAscending());
}

}  // namespace afferent
