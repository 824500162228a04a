#include "afferent/scene/trial.hpp"

#include "afferent/hand/random.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {

void check(const scene::Trial& trial, const Scene& scene, SceneFaults& faults) {
    faults.check("trial.user", "",
                 [&] { (void)TrialUser(trial.user, trial.motor.force_limit_n, scene.seed); });
    faults.check("trial.emg", "", [&] {
        (void)SurfaceEmg(trial.emg, scene.hand.emg_rate_hz, scene.seed, Stream::closing_emg);
    });
    faults.check("trial.motor", "", [&] { (void)ProsthesisMotor(trial.motor); });
    faults.check("trial", "", [&] { TrialObjects{trial.object, trial.slippery}.check(); });
}

}  // namespace afferent
