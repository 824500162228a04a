// The known name that is nearest to a misspelt one, for "did you mean".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afferent {

// The name that takes the fewest changes: letters inserted, left out, replaced, or swapped with their
// neighbour; the first of several. Nothing if more than a third of the typed letters would have to change.
std::optional<std::string> nearest_name(std::string_view typed, const std::vector<std::string>& names);

}  // namespace afferent
