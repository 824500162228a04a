// Runs gnuplot, where it is installed.
#pragma once

#include <string>
#include <string_view>

namespace afferent {

enum class Drawn { done, no_gnuplot, failed };

struct [[nodiscard]] Drawing {
    Drawn outcome;
    std::string message;  // what gnuplot said, if it failed
};

// Runs a script. No shell is involved, and the user's own settings of gnuplot are not read.
Drawing run_gnuplot(std::string_view script);

}  // namespace afferent
