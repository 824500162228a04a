#include "afferent/scene/parameters.hpp"

namespace afferent {

NeuronParameters neuron_parameters(const proto::Neuron& neuron) {
    return {.tau_m_ms = neuron.tau_m_ms(),
            .tau_g_ms = neuron.tau_g_ms(),
            .v_r_mv = neuron.v_r_mv(),
            .v_th_mv = neuron.v_th_mv(),
            .e_k_mv = neuron.e_k_mv(),
            .delta_g = neuron.delta_g(),
            .refractory_ms = neuron.refractory_ms()};
}

TuningTarget tuning_target(const proto::Tuning& tuning, bool transient, double share) {
    TuningTarget target;
    target.rate = tuning.rate() == proto::ONSET ? RateKind::onset : RateKind::steady;
    target.rate_hz = tuning.rate_hz();
    target.input = share * (transient ? tuning.slope_n_per_s() : tuning.force_n());
    target.begin_input = share * (transient ? tuning.begin_slope_n_per_s() : tuning.begin_force_n());
    if (tuning.has_other_rate_hz()) target.other_rate_hz = tuning.other_rate_hz();
    return target;
}

Sensor::Parameters sensor_parameters(const proto::Sensor& sensor) {
    Sensor::Parameters parameters{.full_scale_n = sensor.full_scale_n(),
                                  .adc_bits = sensor.adc_bits(),
                                  .noise_counts = sensor.noise_counts(),
                                  .hysteresis = sensor.hysteresis()};
    if (sensor.has_force_resistance()) {
        const proto::ForceResistance& curve = sensor.force_resistance();
        parameters.force_resistance = {.maximum_ohm = curve.maximum_ohm(),
                                       .minimum_ohm = curve.minimum_ohm(),
                                       .half_force_n = curve.half_force_n(),
                                       .divider_ohm = curve.divider_ohm()};
    }
    return parameters;
}

EmgGain::Parameters gain_parameters(const proto::Gain& gain) {
    return {.onset_n = gain.onset_n(),
            .lambda_n = gain.lambda_n(),
            .limit_n = gain.limit_n(),
            .shape =
                gain.shape() == proto::CONTINUOUS ? EmgGain::Shape::continuous : EmgGain::Shape::exponential};
}

Gripper::Parameters gripper_parameters(const proto::Hand& hand) {
    return {.time_constant_ms = hand.motor().time_constant_ms(),
            .speed_mm_per_s = hand.motor().speed_mm_per_s(),
            .force_limit_n = hand.motor().force_limit_n(),
            .dead_band = hand.motor().dead_band(),
            .stiffness_n_per_mm = hand.object().stiffness_n_per_mm(),
            .distance_mm = hand.object().distance_mm()};
}

User::Parameters user_parameters(const proto::User& user) {
    return {.close_at_s = user.close_at_s(),
            .close_for_s = user.close_for_s(),
            .hold_for_s = user.hold_for_s(),
            .open_for_s = user.open_for_s(),
            .effort = user.effort(),
            .ramp_s = user.ramp_s(),
            .hold_effort = user.hold_effort()};
}

}  // namespace afferent
