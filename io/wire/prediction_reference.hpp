// What both ends of a link that loses packets know in common, so that a packet can refer to it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/io/wire/spike_predictor.hpp"

namespace afferent {

// What a packet's payload begins with: from which position it is told, in spans before the packet's begin,
// and whether nothing is known there.
struct ReferenceName {
    std::uint32_t spans_back = 0;
    bool is_origin = true;

    friend bool operator==(const ReferenceName&, const ReferenceName&) = default;
};
void append_name(const ReferenceName& name, std::string& payload);
// Takes it from the payload's begin; nothing where it does not begin with one.
std::optional<ReferenceName> take_name(std::span<const std::byte>& payload);

// Holds a predictor as it was at one position, the reference, and all that has been told since then. The
// sender moves the reference when the receiver acknowledges packets, and each packet names the reference that
// it was encoded from. So a lost packet costs its own time and nothing after it. Positions are in packet
// spans since the start of the scene.
class PredictionReference {
  public:
    using Told = SpikePredictor::Told;

    // Throws ParameterError, as layout.check().
    explicit PredictionReference(const PacketLayout& layout);

    // Nothing is known there, and nothing has been told since.
    void begin(std::int64_t position);

    std::int64_t position() const noexcept { return position_; }
    // Nothing is known there.
    bool is_origin() const noexcept { return is_origin_; }
    // Where what has been told ends.
    std::int64_t end() const noexcept { return position_ + static_cast<std::int64_t>(spans_.size()); }
    // Which part of what is remembered at most it takes; not to exceed 1. The sender begins anew with a half,
    // so that the receiver, whose reference follows, has room.
    double fill() const noexcept {
        return std::max(static_cast<double>(spans_.size()) / most_spans,
                        static_cast<double>(told_.size()) / static_cast<double>(most_told_));
    }

    // The next span, and more of the last one.
    void record(std::span<const Told> told);
    void record_more(std::span<const Told> told);
    // The last span is known in part; nobody refers to it before it is known as a whole, or not at all.
    void set_last_known(bool known) noexcept { spans_.back().known = known; }
    // What comes until there is lost. Once the reference is full, nothing more is recorded.
    void record_lost(std::int64_t end);
    // Makes the predictor foresee the span that begins at `to` from what is known of the time until `from`.
    // position() <= from <= end(), from <= to.
    void foresee(std::int64_t from, std::int64_t to, SpikePredictor& predictor) const;

    // Moves the reference; position() <= position <= end().
    void move(std::int64_t position);

    // How many spans before end() are known, how many before those are not, and so on, back to the reference.
    template <class Add>
    void describe(const Add& add) const {
        bool known = true;
        std::uint32_t count = 0;
        for (auto span = spans_.rbegin(); span != spans_.rend(); ++span, ++count)
            if (span->known != known) {
                add(count);
                known = !known;
                count = 0;
            }
        add(count);
    }
    // As the other end has described it, back from `end`, which is at most end(). False, and nothing is
    // marked: it goes back to before begin(), and rests on what is known no longer.
    template <class Counts>
    bool mark(std::int64_t end, const Counts& counts) {
        std::int64_t begin = end;
        for (const std::uint32_t count : counts) begin -= count;
        if (begin < origin_) return false;
        bool known = true;
        std::int64_t at = end;
        for (const std::uint32_t count : counts) {
            for (std::uint32_t i = 0; i < count && at > position_; ++i)
                spans_[static_cast<std::size_t>(--at - position_)].known = known;
            known = !known;
        }
        return true;
    }

    // Packets refer no further back.
    static constexpr std::int64_t most_spans = 2048;

  private:
    struct Span {
        std::uint32_t told;
        bool known;
    };

    // Takes a predictor from the reference to `until`. Returns how many spikes were told by then.
    std::size_t follow(std::int64_t until, SpikePredictor& predictor) const;

    SpikePredictor predictor_;  // at the reference
    std::size_t most_told_;
    std::int64_t span_ticks_;
    std::int64_t origin_ = 0;  // where it began
    std::int64_t position_ = 0;
    bool is_origin_ = true;
    std::vector<Span> spans_;  // since the reference
    std::vector<Told> told_;   // of all of them
};

}  // namespace afferent
