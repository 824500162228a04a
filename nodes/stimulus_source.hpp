// Samples of skin that stimuli touch.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "afferent/nodes/sample_source.hpp"
#include "afferent/nodes/stimuli.hpp"
#include "afferent/runtime/event_queue.hpp"

namespace afferent {

// An element is sampled while a stimulus touches it, once right before, and until the encoders that read it
// have settled; before and after that it costs nothing. Elements that do not read 0 at rest are sampled at
// the beginning as well, and every scan of noisy sensors is of all elements. Several scans, each of
// neighbouring elements, may have the same time.
class StimulusSource final : public SampleSource {
  public:
    // The scene's source is stimuli.
    explicit StimulusSource(const Plan& plan);

    std::optional<Due> next() override;
    std::optional<Scan> take(double hand_force_n) override;
    Error refusal() const override;

  private:
    // The state of one patch that has elements of its own.
    struct Skin {
        const std::vector<AnyStimulus>* stimuli;
        std::vector<double> forces_n;
        std::vector<std::uint64_t> active_until;  // the last sample of each element; 0: it has been left
        std::vector<std::uint32_t> active;        // in order
        std::uint64_t settling = 0;               // samples
        std::uint64_t sample = 0;                 // that is due
    };

    void begin(std::size_t patch);
    void press(std::size_t patch, TimePoint time);
    // Makes the element active until then.
    void activate(Skin& skin, std::uint32_t element, std::uint64_t until);
    TimePoint time_of(std::size_t patch, std::uint64_t sample) const noexcept;
    void schedule(std::size_t patch);

    std::map<double, std::vector<AnyStimulus>> stimuli_;  // by the pitch of those that feel them
    std::vector<Skin> skins_;                             // by patch
    EventQueue queue_;
    // Elements that become active at a sample, and all that are, while they are put in order.
    std::vector<std::uint32_t> fresh_;
    std::vector<std::uint32_t> merged_;
    // Progress within the scan that is due: whether its forces have been found, and how many of its active
    // elements have been taken.
    bool pressed_ = false;
    std::size_t taken_ = 0;
};

}  // namespace afferent
