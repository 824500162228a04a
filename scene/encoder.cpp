#include "afferent/scene/encoder.hpp"

#include "afferent/neurons/tuning.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/patch_plan.hpp"
#include "afferent/scene/plan_items.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

// A target as the scene has it: the grip force, or its rate of change, with the names of the fields.
struct GripTarget {
    const char* name;
    double value;
    const char* begin_name;
    double begin;

    void check() const {
        require(begin >= 0, begin_name, ">= 0", begin);
        require(value > begin, name, (std::string("> ") + begin_name).c_str(), value);
    }
};

// In terms of what the mean afferent of the patch reads.
TuningTarget target_of(const PatchPlan& patch, const scene::Tuning& tuning, const GripTarget& target) {
    return {.rate = tuning.rate,
            .rate_hz = tuning.rate_hz,
            .input = patch.mean_share() * target.value,
            .begin_input = patch.mean_share() * target.begin,
            .other_rate_hz = tuning.other_rate_hz};
}

// Encoders without their gain and bias.
template <class Inner>
EncoderParameters kind_of(const typename Inner::Parameters& inner,
                          const std::optional<scene::SlowAdaptation>& slow) {
    if (!slow) return inner;
    return typename SlowlyAdapting<Inner>::Parameters{inner, slow->part, Seconds(slow->time_s)};
}

EncoderParameters kind_of(const scene::Sustained& sustained) {
    if (!sustained.dynamic) return kind_of<Sustained>({}, sustained.slow_adaptation);
    return kind_of<DynamicSustained>(
        {0, 0, Seconds(Milliseconds(sustained.dynamic->time_ms)), sustained.dynamic->corner_hz},
        sustained.slow_adaptation);
}

EncoderParameters kind_of(const scene::Transient& transient) {
    const Rectification rectification{transient.negative_ratio, transient.threshold_n_per_s};
    if (!transient.corner_hz) return Transient::Parameters{0, 0, rectification};
    return BandTransient::Parameters{0, 0, *transient.corner_hz, rectification};
}

class EncoderPlanner {
  public:
    EncoderPlanner(PatchPlan& plan, const scene::Tuning& tuning, PatchFaults& faults)
        : plan_(plan), tuning_(tuning), faults_(faults) {}

    bool operator()(const scene::Sustained& sustained) {
        return tuned({"force_n", tuning_.force_n, "begin_force_n", tuning_.begin_force_n},
                     sustained.gain_mv_per_n, sustained.bias_mv, ".encoder.sustained", kind_of(sustained));
    }

    bool operator()(const scene::Transient& transient) {
        if (!transient.gain_mv_s_per_n && transient.threshold_n_per_s > 0) {
            faults_.refuse(".encoder", "encoder: threshold_n_per_s without a gain; tuning has no threshold");
            return false;
        }
        return tuned(
            {"slope_n_per_s", tuning_.slope_n_per_s, "begin_slope_n_per_s", tuning_.begin_slope_n_per_s},
            transient.gain_mv_s_per_n, transient.bias_mv, ".encoder.transient", kind_of(transient));
    }

    bool operator()(const scene::Vibration& vibration) {
        return faults_.check(".encoder.vibration", [&] {
            if (!vibration.gain_mv_s2_per_n)
                throw ParameterError("gain_mv_s2_per_n", "given, as a vibration has no tuning", "absent");
            set(
                Vibration::Parameters{
                    0, 0, vibration.corner_hz, {vibration.negative_ratio, vibration.threshold_n_per_s2}},
                *vibration.gain_mv_s2_per_n, vibration.bias_mv.value_or(0));
        });
    }

  private:
    void set(const EncoderParameters& kind, double gain, double bias_mv) {
        plan_.encoder = with_gain(kind, gain, bias_mv);
        afferent::check(plan_.encoder);
    }

    // `kind` is the encoder without its gain and bias, which the tuning solves where they are not given.
    bool tuned(const GripTarget& target, std::optional<double> gain, std::optional<double> bias_mv,
               const char* field, const EncoderParameters& kind) {
        plan_.target = target_of(plan_, tuning_, target);
        if (!gain) {
            if (bias_mv) {
                faults_.refuse(".encoder", "encoder: a bias without a gain; tuning solves both");
                return false;
            }
            const bool solved = faults_.check(".neuron.tuning", [&] {
                target.check();
                require(plan_.mean_share() > 0, target.name, "felt by elements with a share > 0",
                        plan_.mean_share());
                const Tuned found = tune(plan_.neuron, plan_.target);
                gain = found.gain;
                bias_mv = found.bias_mv;
                plan_.neuron = with_adaptation(plan_.neuron, found.delta_g);
            });
            if (!solved) return false;
        }
        return faults_.check(field, [&] { set(kind, *gain, bias_mv.value_or(0)); });
    }

    PatchPlan& plan_;
    const scene::Tuning& tuning_;
    PatchFaults& faults_;
};

// How it differs from full-wave rectification.
std::string describe(const Rectification& rectification, const char* unit) {
    std::string text;
    if (rectification.negative_ratio == 0)
        text = ", its positive half-wave";
    else if (rectification.negative_ratio < 1)
        text = ", its negative half-wave " + decimal(rectification.negative_ratio) + " times";
    if (rectification.threshold > 0) text += ", above " + decimal(rectification.threshold) + unit;
    return text;
}

}  // namespace

bool is_read(const scene::Encoder& encoder, bool by_filter) {
    return std::visit(
        Overloaded{
            [](const scene::Sustained& sustained) { return is_decodable(kind_of(sustained)); },
            [&](const scene::Transient& transient) { return by_filter && is_decodable(kind_of(transient)); },
            [](const scene::Vibration&) { return false; }},
        encoder);
}

bool plan_encoder(PatchPlan& plan, const scene::Patch& patch, PatchFaults& faults) {
    return std::visit(EncoderPlanner(plan, patch.neuron.tuning, faults), patch.encoder);
}

std::string describe(const EncoderParameters& encoder) {
    const auto most_at = [](double corner_hz) { return ", most at " + decimal(corner_hz) + " Hz"; };
    const auto force = [](const Sustained::Parameters&) -> std::string {
        return "drive in proportion to force";
    };
    const auto rise = [&](const DynamicSustained::Parameters& dynamic) {
        return "drive in proportion to force, and to " + decimal(Milliseconds(dynamic.time).count()) +
               " ms of its rise" + most_at(dynamic.corner_hz);
    };
    const auto slow = [](double part, Seconds time) {
        return "; a held one falls by " + decimal(100 * part) + " % over " + decimal(time.count()) + " s";
    };
    return std::visit(Overloaded{force, rise,
                                 [&](const SlowlyAdapting<Sustained>::Parameters& held) {
                                     return force(held) + slow(held.part, held.slow_time);
                                 },
                                 [&](const SlowlyAdapting<DynamicSustained>::Parameters& held) {
                                     return rise(held) + slow(held.part, held.slow_time);
                                 },
                                 [](const Transient::Parameters& transient) {
                                     return "drive in proportion to its rate of change" +
                                            describe(transient.rectification, " N/s");
                                 },
                                 [&](const BandTransient::Parameters& band) {
                                     return "drive in proportion to its rate of change" +
                                            most_at(band.corner_hz) + describe(band.rectification, " N/s");
                                 },
                                 [&](const Vibration::Parameters& band) {
                                     return "drive in proportion to the change of its rate of change" +
                                            most_at(band.corner_hz) + describe(band.rectification, " N/s^2");
                                 }},
                      encoder);
}

}  // namespace afferent
