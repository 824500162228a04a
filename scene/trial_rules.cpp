// The rules of a scene's trial.
#include "afferent/scene/scene_faults.hpp"

namespace afferent {

void check_trial(const Scene& scene, SceneFaults& faults) {
    if (!scene.trial) return;
    const scene::Trial& trial = *scene.trial;
    faults.check("trial.user", "",
                 [&] { (void)TrialUser(trial.user, trial.motor.force_limit_n, scene.seed); });
    faults.check("trial.emg", "", [&] {
        (void)SurfaceEmg(trial.emg, scene.hand.emg_rate_hz, scene.seed, Stream::closing_emg);
    });
    faults.check("trial.motor", "", [&] { (void)ProsthesisMotor(trial.motor); });
    faults.check("trial", "", [&] { TrialObjects{trial.object, trial.slippery}.check(); });
}

}  // namespace afferent
