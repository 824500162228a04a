// The outcome of a call to the outside world: a value, or an error that cannot be ignored.
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
        checksum,      // bytes that were changed on their way
        out_of_order,  // a packet that came late, or twice
        not_allowed,   // this link must not be opened
        unreachable,   // no peer
        closed,        // the peer has gone, or the link has failed
    };

    Kind kind;
    std::string text;  // for a person: what was wrong, and what would have been right
};

// Cannot be ignored. Reading a value that is not there is our own bug and ends the program.
//
//     Result<std::size_t> count = read(...);
//     if (!count) report(count.error().text);
template <class T>
using Result = boost::outcome_v2::basic_result<T, Error, boost::outcome_v2::policy::terminate>;

// `return success();` from a Result<void>.
using boost::outcome_v2::success;

// Leaves the function with the error of a result, or goes on with its value under a name of one's own. It is
// two statements: an `if` or a loop around it needs its braces.
//
//     AFFERENT_TRY(count, read(...));
//     AFFERENT_TRY(close());
#define AFFERENT_TRY(...) BOOST_OUTCOME_TRY(__VA_ARGS__)

}  // namespace afferent
