#include "afferent/scene/decoder.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/readout_plans.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

FilterParameters filter_parameters(const scene::Filter& filter, const scene::Gain& gain) {
    FilterParameters parameters;
    parameters.lead = from_milliseconds(gain.lead_ms);
    const scene::Motion* const given[]{&filter.hold, &filter.movement, &filter.contact};
    for (std::size_t i = 0; i < std::size(given); ++i)
        parameters.motion[i] = {given[i]->speed_n_per_s, given[i]->drift_n2_per_s};
    return parameters;
}

void check_patch(const scene::Decoder& decoder, const Scene& scene, const std::string& name) {
    const auto found = std::ranges::find(scene.patches, name, &scene::Patch::name);
    const auto refuse = [&](const char* rule) { throw ParameterError("patch", rule, "\"" + name + "\""); };
    if (found == scene.patches.end()) refuse("the name of a patch");
    if (!is_read(found->encoder, true))
        refuse(
            "a patch whose encoder has no corner frequency, dynamic term, slow adaptation, half-wave or "
            "threshold, which no "
            "decoder inverts");
    if (!is_read(found->encoder, is_filter(decoder)))
        refuse("a patch with a sustained encoder, unless the decoder is the filter");
}

// What the decoder takes for known, and how well.
std::string known(const Uncertainty& of) {
    const auto percent = [](double part) { return decimal(100 * part) + " %"; };
    return "uncertainty: gains within " + percent(of.gain) + " each and " + percent(of.common_gain) +
           " in common, shares within " + percent(of.share) + " over " + decimal(of.share_time_s) +
           " s, zeros within " + decimal(of.offset_n) + " N, hysteresis within " + percent(of.hysteresis) +
           ", adaptation within " + percent(of.adaptation);
}

void add_brake_item(const Plan& plan, PlanItems& items) {
    const auto& reflex = plan.scene.gain.brake;
    items.add("brake at a contact", plan.controller && reflex,
              !plan.controller ? "nobody reads the estimate"
              : reflex         ? "gain.brake: at " + decimal(reflex->contact_n) + " N, for at most " +
                             decimal(reflex->impulse_ms / reflex->command) + " ms"
                       : "the gain has no brake");
}

void add_age_item(const Plan& plan, PlanItems& items) {
    const double delay_ms = plan.controller ? Milliseconds(plan.controller->afferents.delay).count() : 0;
    const bool answers = delay_ms > 0 && is_filter(plan.scene.decoder);
    items.add("force of now", answers,
              !plan.controller ? "nobody reads the estimate"
              : answers ? "sensor.delay_ms and nerve: the force expected " + decimal(delay_ms) + " ms later"
              : delay_ms > 0 ? "decoder is not the filter: its force is " + decimal(delay_ms) + " ms old"
                             : "sensor.delay_ms is 0 and there is no nerve: an event is of its own time");
}

void add_pulse_item(const Plan& plan, PlanItems& items) {
    const auto& pulse = plan.scene.gain.pulse;
    items.add("closing pulse at a slip", plan.controller && pulse,
              !plan.controller ? "nobody reads the estimate"
              : pulse ? "gain.pulse: for " + decimal(pulse->pulse_ms) + " ms, where the force falls by " +
                            decimal(pulse->fall_n) + " N"
                      : "the gain has no pulse");
}

void add_gain_items(const Plan& plan, PlanItems& items) {
    const scene::Gain& gain = plan.scene.gain;
    items.add("gain by the force that comes", plan.controller && gain.lead_ms > 0,
              !plan.controller   ? "nobody reads the estimate"
              : gain.lead_ms > 0 ? "gain.lead_ms: the force expected in " + decimal(gain.lead_ms) + " ms"
                                 : "gain.lead_ms is 0: the gain goes by the force of now");
    const double sigmas = gain.upper_bound_sigmas;
    items.add("gain by an upper bound", plan.controller && sigmas > 0,
              !plan.controller ? "nobody reads the estimate"
              : sigmas > 0     ? "gain.upper_bound_sigmas: of the force and " + decimal(sigmas) + " sigma"
              : gain.doubtful == EmgGain::Doubtful::by_upper_bound
                  ? "gain.upper_bound_sigmas is 0: only that of a doubtful estimate is by its upper bound"
                  : "gain.doubtful is AS_ESTIMATED: the gain is that of the estimate");
    if (!plan.unreachable_limit.empty())
        items.add("gain of 0 at the limit", false,
                  "gain.accept_unreachable_limit, although " + plan.unreachable_limit);
}

}  // namespace

DecoderParameters decoder_parameters(const Scene& scene) {
    using Parameters = DecoderParameters;
    const scene::Decoder& decoder = scene.decoder;
    return std::visit(
        Overloaded{
            [&](const scene::SlidingWindow& window) -> Parameters {
                return SlidingWindowParameters{.window = from_milliseconds(window.window_ms),
                                               .curve = decoder.curve,
                                               .pooling = decoder.pooling};
            },
            [&](const scene::Exponential& kernel) -> Parameters {
                return ExponentialParameters{.time_constant = from_milliseconds(kernel.time_constant_ms),
                                             .curve = decoder.curve,
                                             .pooling = decoder.pooling};
            },
            [&](const scene::InverseInterval&) -> Parameters {
                return InverseIntervalParameters{.curve = decoder.curve, .pooling = decoder.pooling};
            },
            [](const scene::Inversion&) -> Parameters { return InversionParameters(); },
            [&](const scene::Filter& filter) -> Parameters { return filter_parameters(filter, scene.gain); }},
        decoder.kind);
}

bool is_filter(const scene::Decoder& decoder) { return std::holds_alternative<scene::Filter>(decoder.kind); }

void check(const scene::Decoder& decoder, const Scene& scene, SceneFaults& faults) {
    faults.check("decoder", "", [&] {
        for (const std::string& name : decoder.patch) check_patch(decoder, scene, name);
    });
}

Reflexes::Parameters reflex_parameters(const Scene& scene) {
    const scene::Motor& motor = scene.hand.motor;
    Reflexes::Parameters reflexes;
    if (const auto& brake = scene.gain.brake)
        reflexes.brake = {.command = brake->command,
                          .impulse = from_milliseconds(brake->impulse_ms),
                          .contact_n = brake->contact_n,
                          .release_n = brake->release_n,
                          .release = from_milliseconds(brake->release_ms),
                          .time_constant = from_milliseconds(motor.time_constant_ms),
                          .force_limit_n = motor.force_limit_n,
                          .dead_band = motor.dead_band};
    if (const auto& pulse = scene.gain.pulse)
        reflexes.pulse = {.command = pulse->command,
                          .pulse = from_milliseconds(pulse->pulse_ms),
                          .fall_n = pulse->fall_n,
                          .fall_sigmas = pulse->fall_sigmas,
                          .within = from_milliseconds(pulse->within_ms),
                          .settle = from_milliseconds(pulse->settle_ms),
                          .most = pulse->most,
                          .dead_band = motor.dead_band};
    return reflexes;
}

void check_gain(const Scene& scene, SceneFaults& faults) {
    faults.check("gain", "", [&] {
        (void)EmgGain(scene.gain);
        if (scene.gain.lead_ms > 0 && !is_filter(scene.decoder))
            throw ParameterError(
                "lead_ms", "0 unless the decoder is the filter, which alone knows how fast the force rises",
                scene.gain.lead_ms);
        if (scene.gain.pulse && !is_filter(scene.decoder))
            throw ParameterError("pulse",
                                 "absent unless the decoder is the filter: the estimates of the others fall "
                                 "while the force holds",
                                 "given");
        if (scene.gain.brake)
            require(scene.gain.brake->contact_n < scene.gain.limit_n, "brake.contact_n", "< limit_n",
                    scene.gain.brake->contact_n);
        (void)Reflexes(reflex_parameters(scene));
    });
}

void add_decoder_items(const Plan& plan, PlanItems& items) {
    const bool decoder = plan.controller.has_value();
    items.add("decoder and gain", decoder,
              decoder ? "the estimate is recorded or moves the hand" : "nobody reads the estimate");
    const bool parts = decoder && !plan.controller->parts.empty();
    items.add("decoders of parts", parts,
              parts ? "decoder.parts: " + std::to_string(plan.controller->parts.size()) +
                          " of them, beside the grip's"
                    : "decoder.parts is NONE: the grip alone is estimated");
    add_readout_items(plan, items);
    const bool filter = decoder && is_filter(plan.scene.decoder);
    items.add("uncertainty of the sensors", filter,
              filter    ? known(plan.scene.uncertainty)
              : decoder ? "decoder is not the filter, whose sigma alone contains it"
                        : "nobody reads the estimate");
    add_age_item(plan, items);
    add_gain_items(plan, items);
    add_brake_item(plan, items);
    add_pulse_item(plan, items);
}

}  // namespace afferent
