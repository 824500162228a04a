// What a test cannot do without. Where it is missing an exception is thrown: the test fails with it and ends,
// and the next one runs.
#pragma once

#include <algorithm>
#include <ranges>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "afferent/runtime/result.hpp"

namespace afferent {

// The value of a result; throws the text of its error.
template <class T>
T value_or_throw(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().text);
    if constexpr (!std::is_void_v<T>) return std::move(result.value());
}

// The error of a result; throws where there is a value instead.
template <class T>
Error error_or_throw(const Result<T>& result) {
    if (result) throw std::runtime_error("there is no error");
    return result.error();
}

// The element of a range, which outlives it, whose member has that value.
template <class Range, class Value, class Member>
auto& found_or_throw(Range& range, const Value& value, Member member) {
    const auto found = std::ranges::find(range, value, member);
    if (found == std::ranges::end(range)) throw std::runtime_error("there is no such element");
    return *found;
}

}  // namespace afferent
