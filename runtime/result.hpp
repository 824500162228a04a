// The result of a call to the outside world: a value or an error. Included by programs that run nodes or
// receive packets.
#pragma once

#include <boost/outcome/basic_result.hpp>
#include <boost/outcome/policy/terminate.hpp>
#include <boost/outcome/success_failure.hpp>
#include <boost/outcome/try.hpp>
#include <string>

namespace afferent {

struct Error {
    enum class Kind {
        malformed,     // bytes that no correct peer sends
        checksum,      // bytes corrupted on the way
        out_of_order,  // a late or repeated packet
        not_allowed,   // this link must not be opened
        unreachable,   // no peer
        closed,        // the peer has gone, or the link has failed
    };

    Kind kind;
    std::string text;  // for people: what is wrong, and what is right
};

// Must not be ignored ([[nodiscard]]). Reading the value of an error ends the program.
//
//     Result<std::size_t> count = read(...);
//     if (!count) report(count.error().text);
template <class T>
using Result = boost::outcome_v2::basic_result<T, Error, boost::outcome_v2::policy::terminate>;

// `return success();` from a Result<void>.
using boost::outcome_v2::success;

// Returns the error of a result from the function, or names its value. It expands to two statements, so it
// needs braces after `if` or a loop.
//
//     AFFERENT_TRY(count, read(...));
//     AFFERENT_TRY(close());
#define AFFERENT_TRY(...) BOOST_OUTCOME_TRY(__VA_ARGS__)

}  // namespace afferent
