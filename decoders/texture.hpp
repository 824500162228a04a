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

// Tells of each window of time, which begin at multiples of their length, once no span of it comes any more:
// by the wave in which afferents fire (wave_fit.hpp), and by how much the rates of neighbours differ
// (spatial_variation.hpp).
//
// A lost span has no spikes of any afferent, which does not look like a wave that travels. A window is not
// told if more than half of it has been lost. The spikes of an afferent that fires more often than
// SpikeTrains::fastest_hz are dropped where a window has no room for them, and counted.
//
// A spike costs O(1), and a window the fit. Allocates nothing after construction.
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

    struct Progress {
        TimePoint begin{};  // of the window
        TimePoint heard_until{};
        Duration lost{};            // of the window
        std::uint64_t dropped = 0;  // spikes, and windows that nobody has taken
        friend bool operator==(const Progress&, const Progress&) = default;
    };
    struct Snapshot {
        Progress progress;
        SpikeTrains trains;
        std::optional<PatchTexture> told;
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
    // After so long, a window is heard as a whole.
    Duration history() const noexcept { return trains_.window(); }
    Snapshot snapshot() const { return {progress_, trains_, told_}; }
    // Throws ParameterError, and changes nothing, if it is of other afferents or windows.
    void resume(const Snapshot& snapshot);

    PatchIndex patch() const noexcept { return patch_; }
    // The window that has been told last, if nobody has taken it yet.
    std::optional<PatchTexture> step(TimePoint) noexcept;
    std::uint64_t dropped() const noexcept { return progress_.dropped; }

    std::size_t bytes() const noexcept;

  private:
    static constexpr std::uint32_t not_read = ~std::uint32_t{0};

    TimePoint window_at(TimePoint time) const noexcept;
    TimePoint window_end() const noexcept { return progress_.begin + trains_.window(); }
    // No span before that time comes any more.
    void reach(TimePoint time) noexcept;
    void tell() noexcept;

    PatchIndex patch_;
    std::vector<std::uint32_t> index_of_;  // by address
    WaveFit wave_;
    SpatialVariation variation_;
    SpikeTrains trains_;
    std::optional<PatchTexture> told_;
    Progress progress_;
};

}  // namespace afferent
