// The EMG that moves a scene's hand: a recorded table's, or the simulated user's. Beside a recorded force
// nothing is made up: without a table both muscles rest, unless the scene describes its user.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/hand/user.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Recorded closing EMG, in the order of time.
struct EmgTable {
    std::vector<TimePoint> times;
    std::vector<double> counts;
    // Where the recording was scaled to them; otherwise their median.
    std::optional<double> rest_counts = {};
};

class EmgSource {
  public:
    // Reads the scene's EMG table, if it has one.
    static Result<EmgSource> open(const Scene& scene);
    // With a table that has been read before: empty where the scene has none.
    static EmgSource of(const Scene& scene, EmgTable table);

    // For people: where the EMG comes from, and how it was read. A table given in memory adds nothing.
    const std::vector<std::string>& said() const noexcept { return said_; }
    // Where the table ends; nothing where there is none.
    std::optional<TimePoint> end() const;

    // Empty where the EMG is the simulated user's, or at rest.
    const EmgTable& table() const noexcept { return table_; }

    // Takes the k-th sample of both electrodes; k does not decrease, but for restart().
    Emg sample(std::uint64_t k) noexcept;
    void restart() noexcept { next_ = 0; }
    // What the closing electrode reads while the muscle rests: the median of the table where the scene does
    // not say.
    double closing_rest_counts() const noexcept { return rest_counts_; }

  private:
    EmgSource(const Scene& scene, double rest_counts);
    // The counts of the table at that time.
    double closing_counts(TimePoint time) noexcept;

    double rate_hz_;
    scene::Between between_;
    User user_;
    bool rests_;  // neither a table nor a user
    std::vector<std::string> said_;
    double rest_counts_;
    EmgTable table_;
    std::size_t next_ = 0;
    Emg raw_;
};

}  // namespace afferent
