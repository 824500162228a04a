// A run of a scene from its begin to its end.
#pragma once

#include <memory>
#include <utility>

#include "afferent/nodes/run.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {

inline std::unique_ptr<Run> whole_run(const Plan& plan, Observer output = {}) {
    std::unique_ptr<Run> run = value_or_throw(Run::open(plan, std::move(output)));
    while (!run->done()) value_or_throw(run->do_next());
    run->finish(plan.end());
    return run;
}

}  // namespace afferent
