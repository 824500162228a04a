// Any bytes on the line of an Ability Hand, cut anywhere, while a controller asks to close: forces within the
// sensors' range, and no command beyond what the scene allows.
#include <cmath>

#include "afferent/nodes/ability_hand_driver.hpp"
#include "fuzz.hpp"

namespace afferent {
namespace {

constexpr double full_scale_n = 6;
constexpr Duration step = 500us;

AbilityHandDriver::Parameters parameters() {
    AbilityHandDriver::Parameters parameters{.hand = {}, .full_scale_n = {}, .freeze = 60ms, .safe = 150ms};
    parameters.hand.zero_counts.assign(ability_hand::sensors, 15);
    parameters.full_scale_n.fill(full_scale_n);
    return parameters;
}

// The flexors' targets of a request, where it has any.
class Targets {
  public:
    void take(std::span<const std::byte> written, const scene::AbilityHand& hand) {
        reader_.read(written, [&](std::span<const std::byte> payload) {
            const auto request = ability_hand::read_request(static_cast<std::uint8_t>(hand.address), payload);
            must(request.has_value());
            ++requests_;
            if (request->command.mode != ability_hand::Mode::position) return;
            for (std::size_t i = 0; i < ability_hand::flexors; ++i) {
                // A finger that says that it is beyond an end has its target there, and not further.
                const double target_deg = request->command.values[i];
                must(std::isfinite(target_deg) && target_deg >= -30 && target_deg <= 150.01);
            }
        });
        must(reader_.refused() == 0);
    }
    std::uint64_t requests() const { return requests_; }

  private:
    ability_hand::FrameReader reader_;
    std::uint64_t requests_ = 0;
};

}  // namespace
}  // namespace afferent

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace afferent;
    FuzzInput input(data, size);
    const std::size_t piece = 1U + input.byte();
    const AbilityHandDriver::Parameters given = parameters();
    MonotonicTime now{1s};
    AbilityHandDriver driver(given, now);
    Targets targets;
    std::uint64_t samples = 0;
    while (!input.empty()) {
        now += step;
        driver.follow({1.0, now, now});
        targets.take(driver.poll(now), given.hand);
        driver.read(now, input.bytes(piece), [&](MonotonicTime, std::span<const double> forces_n) {
            ++samples;
            for (const double force_n : forces_n) must(force_n >= 0 && force_n <= full_scale_n);
        });
        if (piece % 7 == 0) driver.take_zero(now);
    }
    // No more samples than requests: what nobody asked for is none.
    must(samples <= targets.requests());
    must(driver.readings(now).replies == samples);
    for (int notes = 0; driver.next_note(); ++notes) must(notes < 1000);
    return 0;
}
