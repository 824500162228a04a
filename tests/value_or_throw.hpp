// The value of a result that a test cannot do without.
#pragma once

#include <stdexcept>
#include <type_traits>
#include <utility>

#include "afferent/runtime/result.hpp"

namespace afferent {

// Throws the error's text where there is no value: the test fails with it and ends, and the next one runs.
template <class T>
T value_or_throw(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().text);
    if constexpr (!std::is_void_v<T>) return std::move(result.value());
}

}  // namespace afferent
