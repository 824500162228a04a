#include "afferent/runtime/number_sorter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace afferent {
namespace {

template <class Number>
void expect_sorts(std::size_t size, Number largest) {
    std::mt19937_64 random(size);
    std::uniform_int_distribution<Number> any(0, largest);
    std::vector<Number> numbers(size);
    for (Number& number : numbers) number = any(random);
    std::vector<Number> expected = numbers;
    std::sort(expected.begin(), expected.end());
    const NumberSorter sorter;
    sorter.sort(numbers);
    EXPECT_EQ(numbers, expected);
    sorter.sort(numbers);
    EXPECT_EQ(numbers, expected) << "sorted before";
}

// Sizes around those of vectors and of what is sorted without them; few numbers repeat, or nearly all.
TEST(NumberSorter, SortsAsTheStandardLibraryDoes) {
    for (const std::size_t size : {0, 1, 2, 7, 64, 65, 1000, 100'000}) {
        expect_sorts<std::uint32_t>(size, 0xffff'ffff);
        expect_sorts<std::uint32_t>(size, 3);
        expect_sorts<std::uint64_t>(size, 0xffff'ffff'ffff'ffff);
        expect_sorts<std::uint64_t>(size, 3);
    }
}

}  // namespace
}  // namespace afferent
