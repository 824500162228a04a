// Embeds the spiking coprocessor: samples in, address events out.
#include <afferent/engine/coprocessor.hpp>
#include <cstdio>

int main(int argc, char** argv) {
    using namespace afferent;
    if (argc != 2) return std::fputs("usage: embed SCENE\n", stderr), 2;
    Coprocessor coprocessor(Scene::from_file(argv[1]));
    for (TimePoint now = scene_start; now < scene_start + 1s; now += 5ms) {
        const double forces_n[] = {0.5, 0.4, 0.3};  // of the first three elements, held until the next
        coprocessor.push({now, 0, forces_n});
        for (const Event& spike : coprocessor.advance(now + 5ms))
            std::printf("%.9f %u\n", seconds(spike.time), spike.address);
    }
}
