// Runs gnuplot, where it is installed.
#pragma once

#include <string>
#include <string_view>

namespace afferent {

enum class Drawn { done, no_gnuplot, failed };

struct [[nodiscard]] Drawing {
    Drawn outcome;
    std::string message;  // gnuplot's message, if it failed
};

// Runs a script, without a shell and without the user's settings of gnuplot.
Drawing run_gnuplot(std::string_view script);

}  // namespace afferent
