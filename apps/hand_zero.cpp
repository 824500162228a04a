#include "afferent/apps/hand_zero.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <thread>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/hand/ability_hand.hpp"
#include "afferent/nodes/ability_hand_line.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr std::chrono::seconds patience{3};

// Any steady reading is a zero to be told; whether it is one is for people to judge.
constexpr double any_drift_n = 100;

void print(const HandReadings& readings) {
    double hidden_n = 0;
    std::cout << "zero_counts: [";
    for (std::size_t i = 0; i < readings.sensor_count; ++i) {
        const double counts = readings.zero_counts[i];
        std::cout << (i == 0 ? "" : ", ") << std::lround(counts);
        hidden_n += ability_hand::force_n(counts) - ability_hand::force_n(0);
    }
    std::cout << "]\n";
    char text[160];
    std::snprintf(text, sizeof text,
                  "these readings count as %.2f N without them: that is what they hide, should anything have "
                  "touched the sensors",
                  hidden_n);
    say(text);
}

}  // namespace

void print_zero(Scene scene) {
    if (!scene.hand.ability_hand)
        throw Failure(scene.file +
                      ": --zero is for a hand on a line, and the scene has no hand.ability_hand");
    scene.hand.ability_hand->zero_counts.clear();
    scene.hand.ability_hand->zero_drift_n = any_drift_n;
    const Plan plan = make_plan(scene, Commands::wanted);
    const auto hand = value_or_fail(open_ability_hand(plan));
    hand->start([] {});
    hand->take_zero();
    const auto end = std::chrono::steady_clock::now() + patience;
    for (std::string said = "the hand does not answer"; !interrupted();) {
        const HandReadings& readings = hand->readings();
        while (const auto note = hand->next_note()) said = *note;
        if (readings.zeros_taken > 0) return print(readings);
        if (readings.zeros_refused > 0 || std::chrono::steady_clock::now() > end)
            throw Failure(scene.file + ": " + said);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    throw Interrupted();
}

}  // namespace afferent
