// The number by which a chip and the scene that it computes know each other.
#include "afferent/scene/chip_fingerprint.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace afferent {
namespace {

const std::string of_a_chip =
    "duration_s: 60 source { chip { device: 'tty' compare: true } } link { tcp {} } hand {} "
    "patch { name: 'thumb' elements: 3 share: [0.2, 0.2, 0.1] neuron { delta_g: 0.03 fixed_point {} } }"
    "patch { name: 'index' elements: 2 share: [0.1, 0.1] neuron { delta_g: 0.03 fixed_point {} } }";

// Gain, sensor, unit, tick, width and layout: each makes another chip.
TEST(ChipFingerprint, TellsChipsApartByAllThatTheyCompute) {
    const auto fingerprint = [](const std::string& from, const std::string& to) {
        std::string text = of_a_chip;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return chip_fingerprint(make_plan(Scene::from_text(text.replace(at, from.size(), to)))).value();
    };
    std::set<std::uint64_t> seen{fingerprint("", "")};
    EXPECT_EQ(seen.count(fingerprint("'tty'", "'other'")), 1U) << "where it is does not matter";
    for (const auto& [from, to] : std::initializer_list<std::pair<const char*, const char*>>{
             {"elements: 3", "encoder { sustained { gain_mv_per_n: 20 } } elements: 3"},
             {"elements: 3", "encoder { sustained { gain_mv_per_n: 20.1 } } elements: 3"},
             {"elements: 3", "sensor { full_scale_n: 9.99 } elements: 3"},
             {"elements: 3", "sensor { adc_bits: 10 } elements: 3"},
             {"elements: 3", "sensor { force_resistance {} } elements: 3"},
             {"elements: 3",
              "sensor { calibration { counts: 0 } calibration { counts: 4095 force_n: 9 } } elements: 3"},
             {"fixed_point {}", "fixed_point { rounding: TRUNCATION }"},
             {"fixed_point {}", "fixed_point { state_bits: 15 }"},
             {"delta_g: 0.03", "delta_g: 0.031"},
             {"tcp {}", "tcp {} packet_ms: 10"},
             {"tcp {}", "tcp {} tick_us: 200"},
             {"tcp {}", "tcp {} encoding: FIXED_WIDTH"}})
        EXPECT_TRUE(seen.insert(fingerprint(from, to)).second) << to;
}

// Chips that are told their own keep it for years.
TEST(ChipFingerprint, IsTheSameNumberAlways) {
    EXPECT_EQ(chip_fingerprint(make_plan(Scene::from_text(of_a_chip))), 9212874717623377793U);
    std::string text = of_a_chip;
    text.replace(text.find("elements: 3"), 11,
                 "encoder { sustained { gain_mv_per_n: 20 bias_mv: 2 } } elements: 3");
    EXPECT_EQ(chip_fingerprint(make_plan(Scene::from_text(text))), 3296029965686097094U);
}

}  // namespace
}  // namespace afferent
