// What comes back from the outside world: a value, or an error that has to be looked at.
#pragma once

#include <boost/outcome/basic_result.hpp>
#include <boost/outcome/policy/terminate.hpp>
#include <boost/outcome/success_failure.hpp>
#include <string>

namespace afferent {

struct Error {
    enum class Kind {
        malformed,     // bytes that no correct peer sends
        checksum,      // bytes that were changed on their way
        out_of_order,  // a packet from the past: late, or twice
        refused,       // the two sides do not agree, and said so
        not_allowed,   // this link must not be opened
        unreachable,   // no peer
        closed,        // the peer has gone, or the link has failed
        timed_out,
    };

    Kind kind;
    std::string text;  // for a person: what was wrong, and what would have been right
};

// Cannot be ignored. Reading a value that is not there is our own bug and ends the program.
//
//     Result<std::size_t> count = read(...);
//     if (!count) return report(count.error().text);
//     use(count.value());
template <class T>
using Result = boost::outcome_v2::basic_result<T, Error, boost::outcome_v2::policy::terminate>;

// `return success();` from a Result<void>.
using boost::outcome_v2::success;

}  // namespace afferent
