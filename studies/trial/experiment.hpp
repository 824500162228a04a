// A trial under one condition: presents one object after the other, and tells how each one ended.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "afferent/nodes/emg.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/studies/trial/condition.hpp"
#include "afferent/studies/trial/presentation.hpp"

namespace afferent {

// From the sensors to the motor's command this is the code that runs in a hand: sensors, coprocessor,
// packets, frames, channel, watchdog, decoder and gain. User, electrodes, motor and object are simulated.
//
//     const Experiment rate(Scene::from_file("trial.txtpb"), "rate");
//     for (const Presentation& each : rate.present(0, 1000)) broken += each.outcome == Outcome::broken;
class Experiment {
  public:
    using Progress = std::function<bool(std::uint32_t done)>;

    // Reads the EMG table, if the scene has one. Throws SceneError: it can be read; the scene has a trial,
    // and a link that carries packets; the condition exists.
    Experiment(const Scene& scene, std::string_view condition);

    const Condition& condition() const noexcept { return condition_; }
    const Plan& plan() const noexcept { return plan_; }

    // The presentations first, first + 1, ... in their order: the same for any number of threads, which is
    // the scene's. `progress` is called from this thread, every so often; once it returns false, what is done
    // comes back. Throws SpikeStormError.
    std::vector<Presentation> present(std::uint32_t first, std::uint32_t count,
                                      const Progress& progress = {}) const;
    // One of them, a step for each of the controller's.
    std::vector<TraceStep> trace(std::uint32_t number) const;

  private:
    Condition condition_;
    EmgTable emg_;
    Plan plan_;
    std::size_t threads_;
};

}  // namespace afferent
