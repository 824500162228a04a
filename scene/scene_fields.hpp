// The fields of a scene, once: what reads, writes or compares scenes walks over them.
#pragma once

#include <array>
#include <concepts>
#include <type_traits>

#include "afferent/scene/scene.hpp"

namespace afferent {

// each_field(value, f) calls f(name, member) for each field of a scene's struct, and f.arms(member) for a
// variant whose alternatives are fields of the struct itself. Names are those of the text.

template <class Self, class T>
concept Is = std::same_as<std::remove_const_t<Self>, T>;

// What the alternatives of a variant are called, in its order.
template <class Variant>
inline constexpr std::array<const char*, 0> arm_names{};
template <>
inline constexpr std::array arm_names<scene::Encoder>{"sustained", "transient"};
template <>
inline constexpr std::array arm_names<scene::Source>{"simulated_hand", "profile", "table",
                                                     "standard_input", "link",    "pushed"};
template <>
inline constexpr std::array arm_names<scene::Transport>{"in_process", "unix_socket", "tcp",        "udp",
                                                        "serial",     "file",        "named_pipes"};
template <>
inline constexpr std::array arm_names<decltype(scene::Decoder::kind)>{"sliding_window", "exponential"};
template <>
inline constexpr std::array arm_names<scene::Output>{"command_file"};

template <Is<Scene> Self, class F>
void each_field(Self& scene, F&& f) {
    f("name", scene.name);
    f("duration_s", scene.duration_s);
    f("seed", scene.seed);
    f("patch", scene.patches);
    f("source", scene.source);
    f("link", scene.link);
    f("decoder", scene.decoder);
    f("gain", scene.gain);
    f("output", scene.output);
    f("hand", scene.hand);
    f("record", scene.record);
    f("runtime", scene.runtime);
}

template <Is<scene::Patch> Self, class F>
void each_field(Self& patch, F&& f) {
    f("name", patch.name);
    f("elements", patch.elements);
    f("share", patch.share);
    f("elements_of", patch.elements_of);
    f("field", patch.field);
    f("sensor", patch.sensor);
    f("encoder", patch.encoder);
    f("neuron", patch.neuron);
}

template <Is<scene::Field> Self, class F>
void each_field(Self& field, F&& f) {
    f("weight", field.weight);
}

template <Is<scene::Weight> Self, class F>
void each_field(Self& weight, F&& f) {
    f("element", weight.element);
    f("weight", weight.weight);
}

template <Is<scene::Sensor> Self, class F>
void each_field(Self& sensor, F&& f) {
    f("rate_hz", sensor.rate_hz);
    f("full_scale_n", sensor.full_scale_n);
    f("adc_bits", sensor.adc_bits);
    f("noise_counts", sensor.noise_counts);
    f("force_resistance", sensor.force_resistance);
    f("hysteresis", sensor.hysteresis);
    f("calibration", sensor.calibration);
    f("dead_element", sensor.dead_element);
    f("stuck_element", sensor.stuck_element);
    f("out_of_range", sensor.out_of_range);
}

template <Is<Sensor::ForceResistance> Self, class F>
void each_field(Self& curve, F&& f) {
    f("maximum_ohm", curve.maximum_ohm);
    f("minimum_ohm", curve.minimum_ohm);
    f("half_force_n", curve.half_force_n);
    f("divider_ohm", curve.divider_ohm);
}

template <Is<Calibration::Point> Self, class F>
void each_field(Self& point, F&& f) {
    f("counts", point.counts);
    f("force_n", point.force_n);
}

template <Is<scene::StuckElement> Self, class F>
void each_field(Self& stuck, F&& f) {
    f("element", stuck.element);
    f("force_n", stuck.force_n);
}

template <Is<scene::Sustained> Self, class F>
void each_field(Self& encoder, F&& f) {
    f("gain_mv_per_n", encoder.gain_mv_per_n);
    f("bias_mv", encoder.bias_mv);
}

template <Is<scene::Transient> Self, class F>
void each_field(Self& encoder, F&& f) {
    f("gain_mv_s_per_n", encoder.gain_mv_s_per_n);
    f("bias_mv", encoder.bias_mv);
}

template <Is<scene::Neuron> Self, class F>
void each_field(Self& neuron, F&& f) {
    f("tau_m_ms", neuron.tau_m_ms);
    f("tau_g_ms", neuron.tau_g_ms);
    f("v_r_mv", neuron.v_r_mv);
    f("v_th_mv", neuron.v_th_mv);
    f("e_k_mv", neuron.e_k_mv);
    f("delta_g", neuron.delta_g);
    f("refractory_ms", neuron.refractory_ms);
    f("fixed_point", neuron.fixed_point);
    f("tuning", neuron.tuning);
    f("form", neuron.form);
}

template <Is<scene::FixedPoint> Self, class F>
void each_field(Self& chip, F&& f) {
    f("tick_us", chip.tick_us);
    f("state_bits", chip.state_bits);
    f("decay_bits", chip.decay_bits);
    f("rounding", chip.rounding);
}

template <Is<scene::Tuning> Self, class F>
void each_field(Self& tuning, F&& f) {
    f("rate", tuning.rate);
    f("rate_hz", tuning.rate_hz);
    f("force_n", tuning.force_n);
    f("begin_force_n", tuning.begin_force_n);
    f("slope_n_per_s", tuning.slope_n_per_s);
    f("begin_slope_n_per_s", tuning.begin_slope_n_per_s);
    f("other_rate_hz", tuning.other_rate_hz);
}

template <class Self, class F>
requires Is<Self, scene::SimulatedHand> || Is<Self, scene::Pushed> || Is<Self, scene::InProcess>
void each_field(Self&, F&&) {}

template <Is<scene::Profile> Self, class F>
void each_field(Self& profile, F&& f) {
    f("point", profile.point);
}

template <Is<scene::ProfilePoint> Self, class F>
void each_field(Self& point, F&& f) {
    f("time_s", point.time_s);
    f("force_n", point.force_n);
}

template <Is<scene::Table> Self, class F>
void each_field(Self& table, F&& f) {
    f("path", table.path);
    f("column", table.column);
    f("out_of_range", table.out_of_range);
}

template <Is<scene::StandardInput> Self, class F>
void each_field(Self& input, F&& f) {
    f("column", input.column);
    f("out_of_range", input.out_of_range);
}

template <Is<scene::LinkSource> Self, class F>
void each_field(Self& source, F&& f) {
    f("table", source.table);
}

template <Is<scene::Link> Self, class F>
void each_field(Self& link, F&& f) {
    f.arms(link.transport);
    f("keys", link.keys);
    f("tick_us", link.tick_us);
    f("packet_ms", link.packet_ms);
    f("packet_events", link.packet_events);
    f("delivery_ms", link.delivery_ms);
    f("stale_ms", link.stale_ms);
    f("heartbeat_ms", link.heartbeat_ms);
    f("freeze_ms", link.freeze_ms);
    f("safe_ms", link.safe_ms);
    f("encoding", link.encoding);
    f("connect_s", link.connect_s);
    f("channel", link.channel);
    f("bus", link.bus);
}

template <class Self, class F>
requires Is<Self, scene::UnixSocket> || Is<Self, scene::File> || Is<Self, scene::NamedPipes> ||
    Is<Self, scene::CommandFile>
void each_field(Self& at, F&& f) { f("path", at.path); }

template <class Self, class F>
requires Is<Self, scene::Tcp> || Is<Self, scene::Udp>
void each_field(Self& at, F&& f) {
    f("host", at.host);
    f("port", at.port);
}

template <Is<scene::Serial> Self, class F>
void each_field(Self& serial, F&& f) {
    f("device", serial.device);
    f("baud", serial.baud);
}

template <Is<scene::Channel> Self, class F>
void each_field(Self& channel, F&& f) {
    f("bandwidth_bps", channel.bandwidth_bps);
    f("latency_ms", channel.latency_ms);
    f("jitter_ms", channel.jitter_ms);
    f("loss", channel.loss);
    f("reorder", channel.reorder);
    f("duplicate", channel.duplicate);
    f("corrupt", channel.corrupt);
    f("fifo_events", channel.fifo_events);
    f("drop_policy", channel.drop_policy);
}

template <Is<scene::Bus> Self, class F>
void each_field(Self& bus, F&& f) {
    f("cycle_ns", bus.cycle_ns);
    f("rows", bus.rows);
    f("row_events", bus.row_events);
}

template <Is<scene::Decoder> Self, class F>
void each_field(Self& decoder, F&& f) {
    f.arms(decoder.kind);
    f("curve", decoder.curve);
    f("pooling", decoder.pooling);
    f("patch", decoder.patch);
}

template <Is<scene::SlidingWindow> Self, class F>
void each_field(Self& decoder, F&& f) {
    f("window_ms", decoder.window_ms);
}

template <Is<scene::Exponential> Self, class F>
void each_field(Self& decoder, F&& f) {
    f("time_constant_ms", decoder.time_constant_ms);
}

template <Is<EmgGain::Parameters> Self, class F>
void each_field(Self& gain, F&& f) {
    f("onset_n", gain.onset_n);
    f("lambda_n", gain.lambda_n);
    f("limit_n", gain.limit_n);
    f("shape", gain.shape);
}

template <Is<scene::Hand> Self, class F>
void each_field(Self& hand, F&& f) {
    f("emg_rate_hz", hand.emg_rate_hz);
    f("envelope_ms", hand.envelope_ms);
    f("user", hand.user);
    f("emg_table", hand.emg_table);
    f("motor", hand.motor);
    f("object", hand.object);
    f("safe_state", hand.safe_state);
}

template <Is<User::Parameters> Self, class F>
void each_field(Self& user, F&& f) {
    f("close_at_s", user.close_at_s);
    f("close_for_s", user.close_for_s);
    f("hold_for_s", user.hold_for_s);
    f("open_for_s", user.open_for_s);
    f("effort", user.effort);
    f("ramp_s", user.ramp_s);
    f("hold_effort", user.hold_effort);
}

template <Is<scene::EmgTable> Self, class F>
void each_field(Self& table, F&& f) {
    f("path", table.path);
    f("column", table.column);
    f("rest_counts", table.rest_counts);
    f("full_scale_counts", table.full_scale_counts);
}

template <Is<scene::Motor> Self, class F>
void each_field(Self& motor, F&& f) {
    f("time_constant_ms", motor.time_constant_ms);
    f("speed_mm_per_s", motor.speed_mm_per_s);
    f("force_limit_n", motor.force_limit_n);
    f("dead_band", motor.dead_band);
}

template <Is<scene::Object> Self, class F>
void each_field(Self& object, F&& f) {
    f("stiffness_n_per_mm", object.stiffness_n_per_mm);
    f("distance_mm", object.distance_mm);
}

template <Is<scene::Record> Self, class F>
void each_field(Self& record, F&& f) {
    f("events", record.events);
    f("force", record.force);
    f("picture", record.picture);
}

template <Is<scene::Runtime> Self, class F>
void each_field(Self& runtime, F&& f) {
    f("threads", runtime.threads);
    f("spikes_per_window", runtime.spikes_per_window);
}

}  // namespace afferent
