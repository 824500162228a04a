// Spikes as both ends of a session foresee them, and the payload of those that came otherwise.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/interval_law.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/number_sorter.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// Each end has one and calls it for the same spans in the same order: encode() at the coprocessor, decode()
// or presume() at the hand. Both then foresee the same spikes, since all of it is integer arithmetic.
//
// Of each afferent both know its last spike, its adaptation, and the drive of its last interval. Held, and
// changed as the drives of the others of its patch have changed since, it says when the next spike comes, and
// the afferent's past misses how surely (spike_chances.hpp). Patches of one law count for each other as far
// as their drives have changed alike before. While that time is near, each span has one symbol for the
// afferent: in which tick it fired, or that it did not. The spikes of all others are listed, as gaps of their
// addresses. Symbols are range-coded (range_coder.hpp), so that what came as it was likely to costs next to
// nothing.
//
// With a tolerance, a spike that comes within it of the foreseen tick is told as foreseen, and both ends go
// on as if it had come exactly then; all others are told to their tick.
class SpikePredictor {
  public:
    // Throws ParameterError, as layout.check().
    explicit SpikePredictor(const PacketLayout& layout);

    // The codes of the next span, as PayloadCodec has them: with waiting(), at most max_events. Returns
    // whether any of them is other than presumed; if none is, the payload is empty, and need not be sent.
    struct Manner {
        bool exactly = false;  // without a tolerance, and to be sent in any case
        bool last = false;     // none of them waits for the next span
    };
    bool encode(std::span<const Code> codes, std::string& payload, Manner manner);
    // What the other end is told of with the last span; valid until the next call.
    struct Told {
        Address address;
        std::uint16_t tick;
        bool as_foreseen;  // and not exactly
    };
    std::span<const Told> told() const noexcept { return told_; }
    // What the symbols of the last span take before they are rounded to bytes, be they sent or not.
    double information_bits() const noexcept { return information_bits_; }
    // How many wait to be told with the next: they came a little before they were foreseen.
    std::size_t waiting() const noexcept { return waiting_.size(); }

    // The codes of the next span by its payload, those presumed if that is empty; valid until the next call.
    // An error is `malformed`: after it this end no longer knows what the other foresees, until both start
    // over.
    Result<std::span<const Code>> decode(std::span<const std::byte> payload, bool exactly);

    // Further codes of the last span, in whose payload they had no room.
    void add(std::span<const Code> codes);

    // The codes of the next span where nothing was sent for it; valid until the next call.
    std::span<const Code> presume();

    // For a predictor that both ends keep up to date from what was received, and not from payloads:
    // learn() passes over a span whose spikes are known to both, skip() over a span that was lost. After
    // skip() the spikes are assumed to have come when they were foreseen, with a greater spread.
    void learn(std::span<const Told> spikes);
    void skip();

    // Foresees as another does; what waits to be told still does.
    void foresee_as(const SpikePredictor& other);

    // Starts over, with nothing foreseen; the next span begins `ticks` after the start of the scene.
    void restart(std::uint64_t ticks);

    // The same number at both ends as long as they foresee the same: it sums up all spikes and what followed
    // from each.
    std::uint32_t check() const noexcept { return check_; }

    static constexpr std::size_t bytes_per_afferent = 24;
    // What one symbol takes at most.
    static constexpr double most_symbol_bits = 18;

    // No payload of this layout is longer, nor is that of a further part of a packet.
    static std::size_t most_bytes(const PacketLayout& layout);

  private:
    struct Afferent {
        std::uint32_t last = 0;      // when it fired, in sixteenths of a tick, modulo 2^32
        std::uint32_t interval = 0;  // until the spike that is foreseen; 0: none is
        std::uint32_t g = 0;         // after the last spike
        std::uint32_t drive = 0;     // of the last interval; 0: not known
        std::uint16_t spread = 0;
        std::uint16_t level = 0;       // of all drives, at the last spike
        std::uint32_t next : 24 = 0;   // in the same place of the calendar
        std::uint32_t held : 6 = 0;    // spikes since the last whose tick is known
        std::uint32_t fired : 1 = 0;   // there is a last spike
        std::uint32_t listed : 1 = 0;  // is in the calendar
    };
    static_assert(sizeof(Afferent) == bytes_per_afferent);

    // How the drives have changed in a span, as its spikes tell.
    struct Change {
        std::int64_t gained = 0;  // the sum over the spikes
        std::int64_t spikes = 0;
    };

    // The afferents of a patch, and how their drives change together: what some of them have just shown of
    // the force counts for all that have not fired since.
    struct Group {
        Address end;
        std::uint32_t law;
        std::uint32_t drive = 0;  // typical of its afferents' intervals; 0: not known
        std::uint16_t level = 0;  // of all drives, modulo 2^16
        // How far its drives change as those of the other groups of its law, up to `alike`. At first those
        // count as its own, as of fingers that close on one object.
        static constexpr std::uint16_t alike = 256;
        std::uint16_t follows = alike;
        Change own = {};  // in the span

        // At the end of a span, in which all groups of its law together changed so.
        void settle(const Change& all) noexcept;
    };

    struct Window;  // of one afferent in the span
    class Encode;
    class Decode;
    class Presume;

    template <class Coder>
    void walk(Coder& coder, std::uint32_t tolerance);
    // When the next spike is foreseen, in sixteenths of a tick from the begin of the span.
    std::int64_t due(const Afferent& afferent, const Group& group) const noexcept;
    static std::uint32_t interval_now(const Afferent& afferent, const Group& group) noexcept;
    bool is_near(const Afferent& afferent, std::int64_t due_at, std::int64_t from) const noexcept;
    std::int64_t patience(const Afferent& afferent) const noexcept;
    template <class Visit>
    void visit_active(const Visit& visit);
    void fire(Address address, Group& group, std::uint32_t tick, bool as_foreseen) noexcept;
    void foresee(Afferent& afferent, Group& group, std::uint32_t tick, bool as_foreseen) noexcept;
    void settle_levels() noexcept;
    void count_in_check(Address address) noexcept;
    void follow_told(Afferent& afferent, const Group& group, std::uint32_t tick) noexcept;
    void pass_over(Afferent& afferent, const Group& group) noexcept;
    void end_span() noexcept;
    void settle(Address address, const Group& group) noexcept {
        settle(address, due(afferents_[address], group));
    }
    void settle(Address address, std::int64_t due_at) noexcept;
    void wake() noexcept;
    void activate(Address address) noexcept { active_[address / 64] |= std::uint64_t{1} << address % 64; }
    std::span<const Code> sorted();
    Group& group_of(Address address) noexcept;
    // Bits of the remainder, in the Rice codes of what is listed: of its count, and of the gaps of addresses.
    std::uint32_t count_bits() const noexcept;
    std::uint32_t gap_bits(std::uint64_t count) const noexcept;

    static constexpr std::uint32_t places = 512;  // of the calendar, one a span
    static constexpr std::uint32_t nobody = 0xff'ffff;

    Address addresses_ = 0;
    std::uint32_t span_ticks_;
    std::uint32_t tolerance_;  // in ticks
    std::uint32_t max_events_;
    std::shared_ptr<const std::vector<IntervalLaw>> laws_;  // of copies, too
    std::vector<Change> changes_;                           // by law
    std::vector<Group> groups_;
    std::vector<Afferent> afferents_;
    std::vector<std::uint64_t> active_;  // a bit for each afferent that may fire soon, or is overdue
    std::array<std::uint32_t, places>
        calendar_;                  // the first afferent of those that become active with a span
    std::uint64_t span_ = 0;        // how many were before
    std::uint32_t begin_ = 0;       // its begin, in sixteenths of a tick, modulo 2^32
    std::uint32_t surprising_ = 0;  // in 2^-12: how likely a span has spikes that nobody foresaw
    std::uint32_t surprises_ = 0;   // in sixteenths: how many it then has
    std::uint32_t check_ = 0;
    double information_bits_ = 0;
    std::vector<Code> codes_;
    std::vector<Told> told_;
    std::vector<std::uint64_t> by_address_;  // address · span ticks + tick of the events to encode
    std::vector<std::uint64_t> unforeseen_;  // those of them that are listed
    std::vector<std::uint64_t> waiting_;     // those that are told with the next span
    std::vector<std::uint64_t> waited_;      // those of the last span
    NumberSorter sorter_;
};

}  // namespace afferent
