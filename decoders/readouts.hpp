// What is read out of a population besides the grip force: the contact on each patch, and its touches.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/contact.hpp"
#include "afferent/decoders/edge.hpp"

namespace afferent {

struct PatchContact {
    std::uint32_t patch = 0;  // of the scene
    ContactEstimate estimate{};
    friend bool operator==(const PatchContact&, const PatchContact&) = default;
};

// Contacts are estimated at the first step of each interval, and touches told one for each patch and step.
// Allocates nothing after construction.
class Readouts {
  public:
    struct Contact {
        std::uint32_t patch;
        ContactReadout::Parameters parameters;
        friend bool operator==(const Contact&, const Contact&) = default;
    };
    struct Parameters {
        std::vector<Contact> contacts{};
        Duration interval{};  // of contacts; > 0 where there are any
        std::vector<EdgeReadout::Parameters> edges{};

        bool empty() const noexcept { return contacts.empty() && edges.empty(); }
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };
    struct Snapshot {
        std::vector<ContactReadout::Snapshot> contacts;
        std::vector<EdgeReadout::Snapshot> edges;
        std::int64_t intervals = 0;
    };

    // Throws ParameterError.
    explicit Readouts(const Parameters& parameters);

    // As of a decoder (decoder.hpp).
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    void lose(TimePoint begin, TimePoint end);
    void presume_silence(TimePoint until);
    void restart(TimePoint start);
    // The last step was at `start`.
    void resume_after(TimePoint start, TimePoint heard_until);
    Duration history() const;
    Snapshot snapshot() const;
    // Throws ParameterError where the snapshot is of other read-outs.
    void resume(const Snapshot& snapshot);
    std::size_t bytes() const;
    // How many patches have each.
    std::size_t contact_patches() const noexcept { return contacts_.size(); }
    std::size_t edge_patches() const noexcept { return edges_.size(); }

    // Times of steps do not decrease.
    void step(TimePoint now);
    // One for each patch where the last step was the first of an interval; else none.
    std::span<const PatchContact> contacts() const noexcept {
        return std::span(estimates_).first(estimated_ ? estimates_.size() : 0);
    }
    // Told since the step before.
    std::span<const EdgeTouch> touches() const noexcept { return touches_; }

  private:
    std::int64_t intervals_until(TimePoint time) const noexcept { return (time - scene_start) / interval_; }

    std::vector<ContactReadout> contacts_;
    std::vector<EdgeReadout> edges_;
    Duration interval_;
    std::int64_t intervals_ = -1;  // begun by the last step
    std::vector<PatchContact> estimates_;
    bool estimated_ = false;
    std::vector<EdgeTouch> touches_;
};

}  // namespace afferent
