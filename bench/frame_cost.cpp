// What does a frame of nine neurons cost a program that embeds the coprocessor? bench/python_cost.py asks,
// and compares.
//
//     afferent_frame_cost SCENE FRAMES ROUNDS: prints, for each round, ns per frame with a scan pushed, and
//     without
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "afferent/engine/coprocessor.hpp"

namespace {

using namespace afferent;

// Runs the frames; returns ns for each, and adds its events.
double ns_per_frame(Coprocessor& coprocessor, int frames, bool push, std::size_t& events) {
    const std::vector<double> forces_n(9, 0.5);
    coprocessor.reset();
    coprocessor.push({scene_start, 0, forces_n});
    const auto began = std::chrono::steady_clock::now();
    TimePoint now = scene_start;
    for (int i = 0; i < frames; ++i, now += 5ms) {
        if (push) coprocessor.push({now, 0, forces_n});
        events += coprocessor.advance(now + 5ms - 1ns).size();
    }
    return Interval(std::chrono::steady_clock::now() - began).count() / frames;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    Coprocessor coprocessor(Scene::from_file(argv[1]));
    const int frames = std::atoi(argv[2]);
    std::size_t events = 0;
    for (int round = 0; round < std::atoi(argv[3]); ++round) {
        const double with_scan = ns_per_frame(coprocessor, frames, true, events);
        std::printf("%.1f %.1f\n", with_scan, ns_per_frame(coprocessor, frames, false, events));
    }
    std::printf("%zu\n", events);
}
