// What slides over a patch: the period, the direction and the speed of a grating, and the roughness of any
// surface.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/decoders/readout.hpp"
#include "afferent/decoders/spatial_variation.hpp"
#include "afferent/decoders/spike_trains.hpp"
#include "afferent/decoders/wave_fit.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// Time is divided into windows, which begin at multiples of their length. For each window the read-out tells
// the wave in which afferents fire (wave_fit.hpp), and by how much the rates of neighbours differ
// (spatial_variation.hpp).
//
// A window ends once no span of it comes any more. Its fit is spread over the steps that follow: each does
// `work_a_step` of it, and the window is told when the fit is complete. If the next window ends before that,
// the rest of the fit is done at once, so that no window is missed.
//
// A lost span has no spikes of any afferent, which does not look like a wave that travels. A window is not
// told if more than half of it has been lost. The spikes of an afferent that fires more often than
// SpikeTrains::fastest_hz are dropped where a window has no room for them, and counted.
//
// A spike costs O(1). Allocates nothing after construction.
class TextureReadout {
  public:
    struct Afferent {
        Address address;
        SkinField field;
        friend bool operator==(const Afferent&, const Afferent&) = default;
    };
    struct Parameters {
        std::size_t addresses = 0;  // in the stream
        PatchIndex patch{};
        std::vector<Afferent> afferents{};
        Duration window{};  // 20 ms to 4 s
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };
    // Fewer waves are not told from chance.
    static constexpr std::size_t fewest = 24;
    // The fit takes a time that grows with the square of the number.
    static constexpr std::size_t most = 256;
    // This work takes some 0.2 ms.
    static constexpr std::size_t work_a_step = 200'000;

    struct Progress {
        TimePoint begin{};  // of the window
        TimePoint heard_until{};
        Duration lost{};            // of the window
        std::uint64_t dropped = 0;  // spikes, and windows that nobody has taken
        friend bool operator==(const Progress&, const Progress&) = default;
    };
    // A window that has ended and whose fit is not complete.
    struct Ended {
        TimePoint end{};
        SpikeTrains trains;
        std::uint32_t steps = 0;  // that have been spent on the fit
    };
    struct Snapshot {
        Progress progress;
        SpikeTrains trains;
        std::optional<PatchTexture> told;
        std::optional<Ended> ended;
    };

    using Readout = PatchTexture;
    // Over a run.
    struct Totals {
        std::uint64_t windows = 0;
        std::uint64_t sliding = 0;
        std::optional<PatchTexture> last_sliding{};
        double roughest_hz = 0;
        void add(const PatchTexture& texture) noexcept {
            ++windows;
            roughest_hz = std::max(roughest_hz, texture.estimate.roughness_hz);
            if (!texture.estimate.slides) return;
            ++sliding;
            last_sliding = texture;
        }
        void add_to(auto& summary, const std::string& patch) const {
            auto& of_patch = summary["texture"][patch];
            of_patch["windows"] = windows;
            of_patch["with_period"] = sliding;
            of_patch["largest_roughness_hz"] = roughest_hz;
            if (!last_sliding) return;
            of_patch["last_period_mm"] = last_sliding->estimate.period_mm;
            of_patch["last_period_sigma_mm"] = last_sliding->estimate.period_sigma_mm;
        }
    };

    // Throws ParameterError, as WaveFit does.
    explicit TextureReadout(const Parameters& parameters);

    // As of a decoder (decoder.hpp).
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept;
    void lose(TimePoint begin, TimePoint end) noexcept;
    void presume_silence(TimePoint) noexcept {}
    void restart(TimePoint start) noexcept;
    void resume_after(TimePoint start, TimePoint) noexcept { restart(start); }
    // All windows that begin later are heard as a whole. The one before them, of which the beginning may be
    // missing, is told by the end of the next.
    Duration history() const noexcept { return 2 * trains_.window(); }
    Snapshot snapshot() const;
    // Repeats the work that has been done on a window that has ended. Throws ParameterError, and changes
    // nothing, if the snapshot is of other afferents or windows.
    void resume(const Snapshot& snapshot);

    PatchIndex patch() const noexcept { return patch_; }
    // Advances the fit. Returns each window once, when its fit is complete; if two are complete, the earlier.
    std::optional<PatchTexture> step(TimePoint) noexcept;
    std::uint64_t dropped() const noexcept { return progress_.dropped; }

    std::size_t bytes() const noexcept;

  private:
    static constexpr std::uint32_t not_read = ~std::uint32_t{0};

    TimePoint window_at(TimePoint time) const noexcept;
    TimePoint window_end() const noexcept { return progress_.begin + trains_.window(); }
    // No span before that time comes any more.
    void reach(TimePoint time) noexcept;
    void end_window() noexcept;
    void begin_fit(TimePoint window_end) noexcept;
    // Does at most that much work on the fit, if one is under way.
    void advance(std::size_t work) noexcept;
    bool same_windows(const SpikeTrains& trains) const noexcept;

    PatchIndex patch_;
    std::vector<std::uint32_t> index_of_;  // by address
    WaveFit wave_;
    SpatialVariation variation_;
    SpikeTrains trains_;
    bool fitting_ = false;
    Ended ended_;          // valid while `fitting_`
    PatchTexture fitted_;  // of `ended_`, filled in by the fit
    std::optional<PatchTexture> told_;
    Progress progress_;
};

}  // namespace afferent
