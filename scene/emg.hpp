// The EMG that moves a scene's hand: the simulated user's, or a recorded table's.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "afferent/hand/emg_envelope.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/io/result.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Envelopes, 0 to 1.
struct Effort {
    double closing = 0;
    double opening = 0;
};

class EmgSource {
  public:
    // Reads the scene's EMG table, if it has one.
    static Result<EmgSource> open(const Scene& scene);

    // Takes the k-th sample of both electrodes.
    Effort sample(std::uint64_t k) noexcept;
    // The last sample of the closing electrode, in counts.
    double closing_counts() const noexcept { return raw_.closing_counts; }

  private:
    EmgSource(const Scene& scene, EmgEnvelope::Parameters closing);

    double rate_hz_;
    User user_;
    EmgEnvelope closing_;
    EmgEnvelope opening_;
    bool recorded_ = false;
    double rest_counts_;
    std::vector<TimePoint> times_;  // of the recording
    std::vector<double> counts_;
    std::size_t next_ = 0;
    Emg raw_;
};

}  // namespace afferent
