// How a command ends early.
#pragma once

#include <stdexcept>
#include <string>

#include "afferent/runtime/result.hpp"

namespace afferent {

// An error that the user can correct. The program prints the text and nothing else.
class Failure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// Thrown after Ctrl-C, once all results are written and printed.
class Interrupted : public std::exception {};

// The value, or a Failure with the error's text.
template <class T>
T value_or_fail(Result<T>&& result) {
    if (!result) throw Failure(result.error().text);
    if constexpr (!std::is_void_v<T>) return std::move(result.value());
}

}  // namespace afferent
