// What a view shows of a stretch of time: samples of the controller, the raster, the link, and notes.
#pragma once

#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/time.hpp"
#include "afferent/view/raster.hpp"

namespace afferent {

// NaN: not known.
inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

// The controller's last step of 20 ms.
struct ViewSample {
    TimePoint time;
    double true_n = not_known;
    double estimate_n = not_known;
    double sigma_n = not_known;
    Doubt doubt = Doubt::none;
    double rate_hz = not_known;
    double gain = not_known;
    double emg = not_known;  // closing, 0 to 1
    double command = not_known;
};

// How the link stands, and what has gone over it so far. An end knows only a part of it.
struct LinkState {
    TimePoint time;
    std::string session = {};  // in a word; empty where there is none to be had
    std::uint64_t sessions = 0;
    std::uint64_t packets = 0;
    std::uint64_t events = 0;
    std::uint64_t bytes = 0;
    std::uint64_t gaps = 0;
    std::uint64_t lost_events = 0;
    std::uint64_t late_packets = 0;
    std::uint64_t stale_packets = 0;
    std::uint64_t dropped_packets = 0;
    std::uint64_t refused_frames = 0;
    std::string grip = {};    // "operating", "frozen" or "safe"; empty where this end does not know
    std::string reason = {};  // for the grip not to be operating
    // How late the steps were, in ms.
    double lateness_p50_ms = not_known;
    double lateness_p99_ms = not_known;
    double lateness_max_ms = not_known;
    std::uint64_t missed_deadlines = 0;
    // What a hand on a line says of its motors: angle and current of each, and whether it is hot or cold.
    struct Motor {
        std::string name;
        double position_deg;
        double current_a;
    };
    std::vector<Motor> motors = {};
    std::string temperature = {};
};

// How many bytes had gone over the link at a time.
struct LinkPoint {
    TimePoint time;
    std::uint64_t bytes;
};

// A time of which no events are known, because their packets were lost.
struct ViewGap {
    TimePoint begin;
    TimePoint end;
};

// Something that happened, in words.
struct ViewNote {
    TimePoint time;
    std::string text;
};

struct Portion {
    std::deque<ViewSample> samples;
    std::deque<RasterRun> raster;
    std::deque<ViewGap> gaps;
    std::deque<LinkPoint> link_points;
    std::optional<LinkState> link;  // the latest
    std::deque<ViewNote> notes;

    bool empty() const noexcept {
        return samples.empty() && raster.empty() && gaps.empty() && link_points.empty() && !link &&
               notes.empty();
    }
    // Takes the other, which is later.
    void append(const Portion& later);
    // Forgets what is older than `span` before the newest, and all gaps and notes but the last hundreds.
    void keep_last(Duration span, Duration bin);
};

}  // namespace afferent
