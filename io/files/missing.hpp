// What a user says about missing values. Included by whoever builds a scene with tables.
#pragma once

namespace afferent {

enum class Missing {
    refuse,
    skip,         // the rows in which they are
    interpolate,  // along a straight line
};

}  // namespace afferent
