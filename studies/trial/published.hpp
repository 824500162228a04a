// What was found with real hands and real objects, to compare with.
#pragma once

#include <optional>
#include <string_view>

#include "afferent/studies/trial/proportion_interval.hpp"

namespace afferent {

// Objects that broke under a condition, and whether the simulated user was fitted to this figure.
struct Published {
    Proportion broken;
    bool is_fitted;
};

// Osborn et al. (MEC 2017), Fig. 4: 27.5 % broken without feedback, 14 % with grip force, 14.5 % with spike
// rate. How many presentations there were is not stated; 200 for each condition is inferred from the figures,
// which are multiples of 0.5 %. None for other conditions.
inline std::optional<Published> published(std::string_view condition) noexcept {
    if (condition == "none") return Published{{55, 200}, true};
    if (condition == "force") return Published{{28, 200}, true};
    if (condition == "rate") return Published{{29, 200}, false};
    return std::nullopt;
}

// Osborn et al. (IEEE Trans. Haptics 2016): with onset-offset events from a leaky
// integrate-and-fire contact detector, broken and slipped objects together were less than half of those
// without feedback.
inline constexpr std::string_view halved_condition = "send_on_delta";
inline constexpr double halved_below = 0.5;

}  // namespace afferent
