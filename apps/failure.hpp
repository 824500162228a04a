// How a command ends early.
#pragma once

#include <cstdint>
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

// Throws Failure if a session broke off, or was interrupted by the peer.
inline void expect_whole_sessions(std::uint64_t broken, std::uint64_t interrupted) {
    if (broken > 0)
        throw Failure(std::to_string(broken) + (broken == 1 ? " session" : " sessions") +
                      " broke off before the scene's end");
    if (interrupted > 0) throw Failure("the session was interrupted before the scene's end");
}

// The value, or a Failure with the error's text.
template <class T>
T value_or_fail(Result<T>&& result) {
    if (!result) throw Failure(result.error().text);
    if constexpr (!std::is_void_v<T>) return std::move(result.value());
}

}  // namespace afferent
