// The messages from a view to its page: JSON, version 1. The page sends none.
//
// hello    Begins a course of the scene; what the page has of another is to be forgotten.
//   version      1
//   course       text: another one after a restart, of the scene or of the program
//   command      "run", "hand", "coprocessor" or "replay"
//   scene        its name
//   limit_n      the gain is 0 from this force on; null where there is no controller
//   raw_bytes_per_s   what all samples would take on a link, packed; 0 where none has a rate
//   raster       {bin_s, rows, patches: [{name, afferents, first_row, rows}]}; patches may share a row
//   portion      the last minute
//   ended        the scene has come to its end
// update   What has come since.
//   portion
//   unseen       how much the scene has told in vain, because the server had no turn for seconds
// dropped  This page was too slow: so many of its messages were dropped, the oldest, before the next.
//   messages     since the page connected
// end      The scene has come to its end.
//
// portion: {
//   samples: {time_s, true_n, estimate_n, sigma_n, doubt, rate_hz, gain, emg, command}   columns of equal
//   length; null:
//            not known. The last step of each 20 ms.
//   raster: [{first_bin, counts}]   events in bins first_bin, first_bin + 1, ... of bin_s each; of each bin
//   all rows.
//            A bin that is not told of is unknown.
//   gaps: [{from_s, to_s}]   of this time no events are known: packets were lost
//   link_points: {time_s, bytes}    how many bytes had gone over the link
//   link:    as in struct LinkState, times in s and ms; null where nothing has changed
//   notes: [{time_s, text}]
// }
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "afferent/view/portion.hpp"
#include "afferent/view/raster.hpp"

namespace afferent {

struct ViewTitle {
    std::string course;
    std::string command;
    std::string scene;
    std::optional<double> limit_n;
    double raw_bytes_per_s = 0;
};

std::string hello_message(const ViewTitle& title, const RasterLayout& layout, const Portion& last,
                          bool ended);
std::string update_message(const Portion& portion, std::uint64_t unseen);
std::string dropped_message(std::uint64_t messages);
std::string end_message();

}  // namespace afferent
