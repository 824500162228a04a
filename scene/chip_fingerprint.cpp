#include "afferent/scene/chip_fingerprint.hpp"

#include <cmath>

namespace afferent {
namespace {

// FNV-1a over the bytes of numbers, the least significant first.
class Hash {
  public:
    void add(std::int64_t number) noexcept {
        for (int byte = 0; byte < 8; ++byte) {
            value_ ^= static_cast<std::uint64_t>(number >> (8 * byte)) & 0xff;
            value_ *= 0x100000001b3;
        }
    }
    std::uint64_t value() const noexcept { return value_; }

  private:
    std::uint64_t value_ = 0xcbf29ce484222325;
};

void add(const FixedPointLif::Codes& c, Hash& hash) {
    for (const std::int64_t number :
         {c.tick_ns, c.threshold, c.reset, c.lowest, c.highest, c.one, c.v_decay, c.g_decay, c.conductance,
          c.g_jump, c.g_most, std::int64_t{c.conductance_bits}, std::int64_t{c.decay_bits},
          std::int64_t{c.refractory_ticks}, std::int64_t{c.input_bits},
          std::int64_t{c.rounding == Rounding::half_even}})
        hash.add(number);
}

// What counts of a converter become: gain, bias and the sensor's curve, as far as a neuron has them. Sampled,
// so that two converters differ here if they differ by more than a rounding somewhere.
void add_encoder(const PatchPlan& patch, const FixedPointLif& neuron, Hash& hash) {
    constexpr int samples = 16;
    if (!patch.proportional()) return;
    const double highest = std::exp2(patch.sensor.adc_bits) - 1;
    hash.add(patch.sensor.adc_bits);
    for (int i = 0; i <= samples; ++i) {
        const double counts = std::round(highest * i / samples);
        hash.add(neuron.input(patch.gain() * patch.force_n(counts) + patch.bias_mv()));
    }
}

}  // namespace

std::optional<std::uint64_t> chip_fingerprint(const Plan& plan) {
    if (!plan.packets) return std::nullopt;
    const PacketLayout& layout = *plan.packets;
    Hash hash;
    for (const std::int64_t number :
         {std::int64_t{layout.addresses}, layout.tick.count(), layout.span.count(),
          std::int64_t{layout.gathered_spans}, std::int64_t{layout.heartbeat_spans()},
          std::int64_t{layout.encoding == Encoding::rice}, std::int64_t{layout.max_events}})
        hash.add(number);
    for (const PatchPlan& patch : plan.patches)
        for (std::uint32_t i = 0; i < patch.afferents(); ++i) {
            const NeuronModel model = patch.neuron_of(i);
            const auto* const parameters = std::get_if<FixedPointParameters>(&model);
            if (!parameters) return std::nullopt;
            const FixedPointLif neuron(*parameters);
            add(neuron.codes(), hash);
            if (i == 0) add_encoder(patch, neuron, hash);
        }
    return hash.value();
}

}  // namespace afferent
