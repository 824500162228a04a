// From the bytes of a chip's line to events of the scene, and to what is known of when.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "afferent/io/wire/cobs.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/nodes/chip_comparison.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

struct ChipReport {
    FrameCounts frames;
    std::uint64_t refused_bytes = 0;        // stretches of the line that hold no frame
    std::uint64_t packets = 0;              // good ones
    std::uint64_t refused_packets = 0;      // that cannot be
    std::uint64_t unknown_packets = 0;      // of another chip, or before the chip has said which it is
    std::uint64_t implausible_packets = 0;  // an afferent fires more often than it can
    std::uint64_t gaps = 0;
    std::uint64_t lost_events = 0;
    std::uint64_t late_events = 0;  // of packets that came when their time had been told as unknown
    std::uint64_t beginnings = 0;   // how often the chip was begun to be followed
    std::uint64_t clock_jumps = 0;  // how often its clock was too far off, and spans were skipped
    double clock_ppm = 0;           // how much faster the chip's clock is than this one's
    std::optional<ChipComparison::Counts> comparison = {};
};

// The chip has a clock of its own. The reader takes its first packet to end when it arrives, but for less
// than a span, so that the chip's spans are spans of the scene. From then on the scene's clock has to follow
// the chip's, by clock_ahead(). Where the two are a span or more apart, the reader skips whole spans.
//
// Reads no clock and no device. Nothing that comes is trusted.
class ChipReader {
  public:
    // Both outlive it. `emulator` is compared with the chip; null: it is not.
    ChipReader(const Plan& plan, Coprocessor* emulator);

    // Nothing before this time is asked for; bytes may have come before. To be called before anything is
    // taken.
    void begin_at(TimePoint time) noexcept {
        known_until_ = time;
        taken_until_ = time - Duration(1);
    }

    // Bytes that came at this time by the clock, and of the scene.
    void read(MonotonicTime at, TimePoint now, std::span<const std::byte> bytes);

    // How far the chip's clock is ahead of the scene's. Measured every quarter of a second, by the packet
    // that was delayed the least in that time, since none can come before its end; returned once.
    std::optional<Duration> clock_ahead() noexcept { return std::exchange(ahead_, std::nullopt); }

    // Events before this time are known, if there is no gap.
    TimePoint known_until() const noexcept { return known_until_; }
    // All events are known that are not before `begin` and before `end`.
    bool knows(TimePoint begin, TimePoint end) const noexcept;
    // Events up to and including `until` that were not taken before, sorted; valid until the next call.
    std::span<const Event> take(TimePoint until);

    // What people should know, in order; nothing if that is all.
    std::optional<std::string> next_note();
    ChipReport report() const;

  private:
    void frame(TimePoint now, std::span<const std::byte> datagram);
    void hello(TimePoint now, const proto::ChipHello& hello);
    void readings(const proto::Readings& readings);
    void packet(TimePoint now, const proto::Envelope& packet);
    std::uint64_t begin_of(const proto::Envelope& packet, std::uint32_t spans) const noexcept;
    void resume(std::uint64_t begin, const proto::Envelope& packet);
    bool follow(TimePoint now, const proto::Envelope& packet);
    bool plausible(const Reception& reception);
    void take_over(const Reception& reception);
    void compare_clocks(TimePoint now, TimePoint end);
    Duration whole_spans(Duration duration) const noexcept;  // the nearest
    void add_gap(TimePoint begin, TimePoint end);
    void tell(std::string note);
    void count_session();

    const Plan& plan_;
    std::uint64_t fingerprint_;
    std::vector<double> most_per_second_;  // events, by address
    std::vector<std::uint32_t> fired_;     // by address, in a packet
    CobsReader cobs_;
    std::optional<PacketReceiver> receiver_;  // nothing: the chip is not followed yet
    std::optional<ChipComparison> comparison_;
    bool counted_ = false;   // it is known how many events it has sent
    std::int64_t near_ = 0;  // a span that the chip has been at not long ago, as far as readings have said it
    bool is_the_scenes_ = false;  // it has said so
    proto::Envelope message_;     // reused
    std::uint32_t refused_in_a_row_ = 0;

    Duration offset_{};  // of the scene's time, beyond the chip's: whole spans
    MonotonicTime at_{};
    TimePoint window_begin_ = TimePoint::min();
    Duration earliest_ = Duration::max();  // that a packet has come after its end, in this window
    std::optional<Duration> ahead_;
    // A packet of the first window, and when it came: what the chip's clock is judged by.
    std::optional<std::pair<TimePoint, MonotonicTime>> judged_since_;

    TimePoint known_until_ = scene_start;
    TimePoint taken_until_ = scene_start - Duration(1);
    std::vector<TimeSpan> gaps_;
    std::deque<Event> events_;
    std::vector<Event> taken_;
    ChipReport report_;
    std::deque<std::string> notes_;
    TimePoint tell_again_at_ = TimePoint::min();    // that the chip has begun again
    TimePoint tell_another_at_ = TimePoint::min();  // that it is another one
};

}  // namespace afferent
