// Tells the touches of a patch apart, and how the edge lies in each, by the first spikes of its afferents.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/decoders/edge_fit.hpp"
#include "afferent/decoders/readout.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// A touch begins with the first spike after the patch has been silent for the time `settle`, takes the first
// spike of each afferent, and is told once no further afferent has fired for the first time for as long. A
// touch of fewer than EdgeFit::fewest afferents is not told.
//
// Where events have been lost, the touch ends, and is told by the first spikes before the loss; the next one
// begins after `settle` of known silence. A decoder that begins in the middle waits for such a silence too.
//
// A spike costs O(1), and a touch the fit: some 20 µs for each hundred of afferents. Allocates nothing after
// construction.
class EdgeReadout {
  public:
    struct Afferent {
        Address address;
        EdgeFit::Afferent fitted;
        friend bool operator==(const Afferent&, const Afferent&) = default;
    };
    struct Parameters {
        std::size_t addresses = 0;  // in the stream
        PatchIndex patch{};
        std::vector<Afferent> afferents{};
        Duration settle{};  // > 0
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };
    // Touches that nobody has taken. Any more, and the oldest are dropped.
    static constexpr std::size_t most_untaken = 16;

    struct Progress {
        bool silent = true;  // long enough for another touch
        bool open = false;   // a touch
        TimePoint begin{};
        TimePoint last_first{};
        TimePoint last{};  // spike, or end of what was lost
        TimePoint heard_until{};
        std::uint64_t dropped = 0;
        friend bool operator==(const Progress&, const Progress&) = default;
    };
    struct Snapshot {
        Progress progress;
        std::vector<EdgeFit::First> firsts;
        std::vector<EdgeTouch> touches;
    };

    using Readout = EdgeTouch;
    // Over a run.
    struct Totals {
        std::uint64_t touches = 0;
        std::optional<EdgeTouch> last{};
        void add(const EdgeTouch& touch) noexcept {
            ++touches;
            last = touch;
        }
        void add_to(auto& summary, const std::string& patch) const {
            auto& of_patch = summary["touches"][patch];
            of_patch["told"] = touches;
            if (!last) return;
            of_patch["last_orientation_deg"] = last->edge.orientation_deg;
            of_patch["last_orientation_sigma_deg"] = last->edge.sigma_deg;
        }
    };

    // Throws ParameterError, as EdgeFit does.
    explicit EdgeReadout(const Parameters& parameters);

    // As of a decoder (decoder.hpp).
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept;
    void presume_silence(TimePoint) noexcept {}
    void restart(TimePoint start) noexcept;
    void resume_after(TimePoint start, TimePoint) noexcept { restart(start); }
    // How long a silence it takes to know where a touch begins.
    Duration history() const noexcept { return settle_; }
    Snapshot snapshot() const;
    // Throws ParameterError, and changes nothing, if it is of other afferents.
    void resume(const Snapshot& snapshot);

    PatchIndex patch() const noexcept { return patch_; }
    // The oldest touch that has been told by now, which is taken.
    std::optional<EdgeTouch> step(TimePoint);
    // The oldest touch that has been told by now and not been taken; null if there is none.
    const EdgeTouch* next() const noexcept { return touches_.empty() ? nullptr : &touches_.front(); }
    void take() noexcept { touches_.erase(touches_.begin()); }
    std::uint64_t dropped() const noexcept { return progress_.dropped; }

    std::size_t bytes() const noexcept;

  private:
    static constexpr std::uint32_t not_read = ~std::uint32_t{0};

    // Nothing has happened until then.
    void wait(TimePoint until) noexcept;
    void tell(TimePoint now) noexcept;

    Duration settle_;
    PatchIndex patch_;
    EdgeFit fit_;
    std::vector<std::uint32_t> index_of_;  // by address
    std::vector<bool> has_fired_;          // in this touch
    std::vector<EdgeFit::First> firsts_;
    std::vector<EdgeTouch> touches_;
    Progress progress_;
};

}  // namespace afferent
