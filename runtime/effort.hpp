// The effort of a user's two muscles. Included by programs that read steps or commands.
#pragma once

namespace afferent {

// Each from 0 (at rest) to 1 (maximal).
struct Effort {
    double closing = 0;
    double opening = 0;
};

}  // namespace afferent
