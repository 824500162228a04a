// Whether tests may take long: sanitizers make some code twenty times slower, and what it computes is the
// same.
#pragma once

namespace afferent {

#ifdef NDEBUG
inline constexpr bool long_runs = true;
#else
inline constexpr bool long_runs = false;
#endif

}  // namespace afferent
