// Embeds a hand's controller beside the coprocessor: events and EMG in, estimate and command out.
#include <afferent/engine/controller.hpp>
#include <afferent/engine/coprocessor.hpp>
#include <cstdio>

int main() {
    using namespace afferent;
    Scene scene;
    scene.patches = {{.name = "thumb", .elements = 3}};
    scene.source = scene::Pushed();
    scene.hand.emg_rate_hz = 200;

    Coprocessor coprocessor(scene);
    Controller controller(scene);
    for (TimePoint now = scene_start; now < scene_start + 2s; now += 5ms) {
        const double force_n = seconds(now);
        const double forces_n[] = {1.2 * force_n, force_n, 0.8 * force_n};
        coprocessor.push({now, 0, forces_n});
        const TimePoint end = now + 5ms;
        controller.observe(now, end, coprocessor.advance(end - 1ns));  // silence is a measurement, too
        const ControllerStep& step = controller.step(end, {.closing_counts = 2300, .opening_counts = 2048});
        std::printf("%.3f s: %.2f N, sigma %.2f N, command %.3f\n", seconds(step.time), step.estimate.force_n,
                    step.estimate.sigma_n, step.command);
    }
}
