// Text from a peer, safe to show on a terminal: control characters become question marks.
#pragma once

#include <algorithm>
#include <string>

namespace afferent {

inline std::string printable(const std::string& text) {
    constexpr std::size_t longest = 300;
    std::string shown = text.substr(0, longest);
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return shown;
}

}  // namespace afferent
