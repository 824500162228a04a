// The fields of a scene, once: what reads, writes or compares scenes walks over them.
#pragma once

#include <array>
#include <concepts>
#include <type_traits>

#include "afferent/scene/field_range.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// each_field(value, f) calls f(name, member) for each field of a scene's struct, and f.arms(member) for a
// variant whose alternatives are fields of the struct itself. Names are those of the text; that of a number
// comes with its range, which scene_rules.cpp checks. An arm without a name has no message of its own: its
// fields are those of the message around it.

template <class Self, class T>
concept Is = std::same_as<std::remove_const_t<Self>, T>;

// What the alternatives of a variant are called, in its order.
template <class Variant>
inline constexpr std::array<const char*, 0> arm_names{};
template <>
inline constexpr std::array arm_names<scene::Encoder>{"sustained", "transient", "vibration"};
template <>
inline constexpr std::array arm_names<decltype(scene::Outline::shape)>{"rectangle", "ellipse"};
template <>
inline constexpr std::array arm_names<scene::Distribution>{"normal", "log_normal", "uniform"};
template <>
inline constexpr std::array arm_names<scene::Source>{"simulated_hand", "profile", "table", "standard_input",
                                                     "link",           "pushed",  ""};
template <>
inline constexpr std::array arm_names<scene::Transport>{"in_process", "unix_socket", "tcp",        "udp",
                                                        "serial",     "file",        "named_pipes"};
template <>
inline constexpr std::array arm_names<decltype(scene::Decoder::kind)>{"sliding_window", "exponential",
                                                                      "interval", "inversion", "filter"};
template <>
inline constexpr std::array arm_names<scene::Output>{"command_file"};

template <Is<Scene> Self, class F>
void each_field(Self& scene, F&& f) {
    f("name", scene.name);
    f(above("duration_s", 0, 1e9), scene.duration_s);
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
    f("trial", scene.trial);
    f("uncertainty", scene.uncertainty);
}

template <Is<scene::Patch> Self, class F>
void each_field(Self& patch, F&& f) {
    f("name", patch.name);
    f(within("elements", 1, scene::most_addresses), patch.elements);
    f(within("share", 0, 1), patch.share);
    f("elements_of", patch.elements_of);
    f("field", patch.field);
    f("outline", patch.outline);
    f("afferents", patch.afferents);
    f("spread", patch.spread);
    f("sensor", patch.sensor);
    f("encoder", patch.encoder);
    f("neuron", patch.neuron);
    f("of_kind", patch.of_kind);
}

template <Is<scene::Field> Self, class F>
void each_field(Self& field, F&& f) {
    f("weight", field.weight);
}

template <Is<scene::Weight> Self, class F>
void each_field(Self& weight, F&& f) {
    f(within("element", 0, scene::most_addresses - 1), weight.element);
    f(above("weight", 0, 1e6), weight.weight);
}

template <Is<scene::Outline> Self, class F>
void each_field(Self& outline, F&& f) {
    f.arms(outline.shape);
    f(within("pitch_mm", 0.05, 1000), outline.pitch_mm);
    f("centre", outline.centre);
}

template <class Self, class F>
requires Is<Self, scene::Rectangle> || Is<Self, scene::Ellipse>
void each_field(Self& shape, F&& f) {
    f(within("width_mm", 0.05, 1000), shape.width_mm);
    f(within("height_mm", 0.05, 1000), shape.height_mm);
}

template <Is<scene::Afferents> Self, class F>
void each_field(Self& afferents, F&& f) {
    f(within("per_cm2", 0.01, 1e5), afferents.per_cm2);
    f(within("jitter", 0, 1), afferents.jitter);
    f(within("field_sd_mm", 0.01, 100), afferents.field_sd_mm);
    f("place", afferents.place);
}

template <Is<Place> Self, class F>
void each_field(Self& place, F&& f) {
    f(within("x_mm", -1000, 1000), place.x_mm);
    f(within("y_mm", -1000, 1000), place.y_mm);
}

template <Is<scene::Spread> Self, class F>
void each_field(Self& spread, F&& f) {
    f("gain", spread.gain);
    f("threshold", spread.threshold);
    f("delta_g", spread.delta_g);
    f("field_sd", spread.field_sd);
    f("phase", spread.phase);
    f("time_class", spread.time_class);
}

template <Is<scene::TimeClass> Self, class F>
void each_field(Self& of_time, F&& f) {
    f(above("part", 0, 1e6), of_time.part);
    f(within("tau_m", 1e-6, 1e6), of_time.tau_m);
    f(within("tau_g", 1e-6, 1e6), of_time.tau_g);
}

template <Is<scene::Normal> Self, class F>
void each_field(Self& normal, F&& f) {
    f(within("mean", 0, 1e6), normal.mean);
    f(within("sd", 0, 1e6), normal.sd);
}

template <Is<scene::LogNormal> Self, class F>
void each_field(Self& log_normal, F&& f) {
    f(above("median", 0, 1e6), log_normal.median);
    f(within("sigma", 0, 3), log_normal.sigma);
}

template <Is<scene::Uniform> Self, class F>
void each_field(Self& uniform, F&& f) {
    f(within("lowest", 0, 1e6), uniform.lowest);
    f(within("highest", 0, 1e6), uniform.highest);
}

template <Is<scene::Sensor> Self, class F>
void each_field(Self& sensor, F&& f) {
    f(within("rate_hz", 0.001, 1e6), sensor.rate_hz);
    f(within("full_scale_n", 1e-6, 1e6), sensor.full_scale_n);
    f(within("adc_bits", 1, 24), sensor.adc_bits);
    f(within("noise_counts", 0, 1e6), sensor.noise_counts);
    f("force_resistance", sensor.force_resistance);
    f(below("hysteresis", 0, 1), sensor.hysteresis);
    f("calibration", sensor.calibration);
    f(within("dead_element", 0, scene::most_addresses - 1), sensor.dead_element);
    f("stuck_element", sensor.stuck_element);
    f(within("reference_v", 1e-6, 1e6), sensor.reference_v);
    f("out_of_range", sensor.out_of_range);
}

template <Is<Sensor::ForceResistance> Self, class F>
void each_field(Self& curve, F&& f) {
    f(above("maximum_ohm", 0, 1e12), curve.maximum_ohm);
    f(above("minimum_ohm", 0, 1e12), curve.minimum_ohm);
    f(within("half_force_n", 1e-6, 1e6), curve.half_force_n);
    f(above("divider_ohm", 0, 1e12), curve.divider_ohm);
}

template <Is<Calibration::Point> Self, class F>
void each_field(Self& point, F&& f) {
    f(within("counts", -1e9, 1e9), point.counts);
    f(within("force_n", -1e6, 1e6), point.force_n);
}

template <Is<scene::StuckElement> Self, class F>
void each_field(Self& stuck, F&& f) {
    f(within("element", 0, scene::most_addresses - 1), stuck.element);
    f(within("force_n", 0, 1e6), stuck.force_n);
}

template <Is<scene::Sustained> Self, class F>
void each_field(Self& encoder, F&& f) {
    f(above("gain_mv_per_n", 0, 1e12), encoder.gain_mv_per_n);
    f(within("bias_mv", -1e12, 1e12), encoder.bias_mv);
}

template <Is<scene::Transient> Self, class F>
void each_field(Self& encoder, F&& f) {
    f(above("gain_mv_s_per_n", 0, 1e12), encoder.gain_mv_s_per_n);
    f(within("bias_mv", -1e12, 1e12), encoder.bias_mv);
    f(within("corner_hz", 0.1, 1e5), encoder.corner_hz);
}

template <Is<scene::Vibration> Self, class F>
void each_field(Self& encoder, F&& f) {
    f(above("gain_mv_s2_per_n", 0, 1e12), encoder.gain_mv_s2_per_n);
    f(within("bias_mv", -1e12, 1e12), encoder.bias_mv);
    f(within("corner_hz", 0.1, 1e5), encoder.corner_hz);
}

template <Is<scene::Neuron> Self, class F>
void each_field(Self& neuron, F&& f) {
    f(within("tau_m_ms", 1e-6, 1e6), neuron.tau_m_ms);
    f(within("tau_g_ms", 1e-6, 1e6), neuron.tau_g_ms);
    f(within("v_r_mv", -1e6, 1e6), neuron.v_r_mv);
    f(within("v_th_mv", -1e6, 1e6), neuron.v_th_mv);
    f(within("e_k_mv", -1e6, 1e6), neuron.e_k_mv);
    f(within("delta_g", 0, 1e6), neuron.delta_g);
    f(within("refractory_ms", 0, 1e6), neuron.refractory_ms);
    f("fixed_point", neuron.fixed_point);
    f("tuning", neuron.tuning);
    f("form", neuron.form);
}

template <Is<scene::FixedPoint> Self, class F>
void each_field(Self& chip, F&& f) {
    f(within("tick_us", 1, 10000), chip.tick_us);
    f(within("state_bits", 4, 32), chip.state_bits);
    f(within("decay_bits", 4, 24), chip.decay_bits);
    f("rounding", chip.rounding);
}

template <Is<scene::Tuning> Self, class F>
void each_field(Self& tuning, F&& f) {
    f("rate", tuning.rate);
    f(above("rate_hz", 0, 1e6), tuning.rate_hz);
    f(above("force_n", 0, 1e6), tuning.force_n);
    f(within("begin_force_n", 0, 1e6), tuning.begin_force_n);
    f(above("slope_n_per_s", 0, 1e9), tuning.slope_n_per_s);
    f(within("begin_slope_n_per_s", 0, 1e9), tuning.begin_slope_n_per_s);
    f(above("other_rate_hz", 0, 1e6), tuning.other_rate_hz);
}

template <class Self, class F>
requires Is<Self, scene::SimulatedHand> || Is<Self, scene::Pushed> || Is<Self, scene::InProcess> ||
    Is<Self, scene::InverseInterval> || Is<Self, scene::Inversion>
void each_field(Self&, F&&) {}

template <Is<scene::Profile> Self, class F>
void each_field(Self& profile, F&& f) {
    f("point", profile.point);
}

template <Is<scene::ProfilePoint> Self, class F>
void each_field(Self& point, F&& f) {
    f(within("time_s", 0, 1e9), point.time_s);
    f(within("force_n", 0, 1e6), point.force_n);
}

template <Is<scene::Table> Self, class F>
void each_field(Self& table, F&& f) {
    f("path", table.path);
    f("column", table.column);
    f("out_of_range", table.out_of_range);
    f("between", table.between);
    f("time_column", table.time_column);
    f("time_unit", table.time_unit);
    f(within("rate_hz", 0.001, 1e6), table.rate_hz);
    f(within("begin_s", -9e9, 9e9), table.begin_s);
    f("unit", table.unit);
}

template <Is<scene::StandardInput> Self, class F>
void each_field(Self& input, F&& f) {
    f("column", input.column);
    f("out_of_range", input.out_of_range);
    f("time_column", input.time_column);
    f("time_unit", input.time_unit);
    f("unit", input.unit);
}

template <Is<scene::LinkSource> Self, class F>
void each_field(Self& source, F&& f) {
    f("table", source.table);
}

template <Is<scene::Edge> Self, class F>
void each_field(Self& edge, F&& f) {
    f(within("direction_deg", -360, 360), edge.direction_deg);
    f(within("speed_mm_per_s", 0, 10000), edge.speed_mm_per_s);
    f(within("begin_mm", -10000, 10000), edge.begin_mm);
    f(within("half_width_mm", 0.001, 1000), edge.half_width_mm);
    f(within("peak_kpa", 0, 1e6), edge.peak_kpa);
    f("press", edge.press);
}

template <Is<scene::Indenter> Self, class F>
void each_field(Self& indenter, F&& f) {
    f(within("x_mm", -10000, 10000), indenter.x_mm);
    f(within("y_mm", -10000, 10000), indenter.y_mm);
    f(within("direction_deg", -360, 360), indenter.direction_deg);
    f(within("speed_mm_per_s", 0, 10000), indenter.speed_mm_per_s);
    f("tip", indenter.tip);
    f(within("radius_mm", 0.001, 1000), indenter.radius_mm);
    f(within("force_n", 0, 1e6), indenter.force_n);
    f(within("depth_mm", 0, 1000), indenter.depth_mm);
    f("press", indenter.press);
}

template <Is<scene::Grating> Self, class F>
void each_field(Self& grating, F&& f) {
    f("pad", grating.pad);
    f(within("direction_deg", -360, 360), grating.direction_deg);
    f(within("speed_mm_per_s", 0, 10000), grating.speed_mm_per_s);
    f(within("period_mm", 0.01, 1000), grating.period_mm);
    f(within("ridge_mm", 0, 1000), grating.ridge_mm);
    f(within("depth_mm", 0, 1000), grating.depth_mm);
    f("press", grating.press);
}

template <Is<scene::Texture> Self, class F>
void each_field(Self& texture, F&& f) {
    f("pad", texture.pad);
    f(within("direction_deg", -360, 360), texture.direction_deg);
    f(within("speed_mm_per_s", 0, 10000), texture.speed_mm_per_s);
    f(within("rms_mm", 0, 100), texture.rms_mm);
    f(within("longest_mm", 0.01, 1000), texture.longest_mm);
    f(within("shortest_mm", 0.01, 1000), texture.shortest_mm);
    f(within("hurst", 0, 1), texture.hurst);
    f(within("seed", 0, 4294967295.0), texture.seed);
    f("press", texture.press);
}

template <Is<Pad> Self, class F>
void each_field(Self& pad, F&& f) {
    f(within("x_mm", -10000, 10000), pad.x_mm);
    f(within("y_mm", -10000, 10000), pad.y_mm);
    f(within("width_mm", 0.01, 1000), pad.width_mm);
    f(within("height_mm", 0.01, 1000), pad.height_mm);
    f(within("peak_kpa", 0, 1e6), pad.peak_kpa);
    f(within("stiffness_kpa_per_mm", 0, 1e6), pad.stiffness_kpa_per_mm);
}

template <Is<Press> Self, class F>
void each_field(Self& press, F&& f) {
    f(within("begin_s", 0, 1e9), press.begin_s);
    f(within("rise_s", 0, 1e9), press.rise_s);
    f(within("hold_s", 0, 1e9), press.hold_s);
    f(within("fall_s", 0, 1e9), press.fall_s);
    f(within("vibration_hz", 0, 1e5), press.vibration_hz);
    f(within("vibration", 0, 1000), press.vibration);
}

template <Is<ElasticSkin> Self, class F>
void each_field(Self& skin, F&& f) {
    f(within("modulus_kpa", 0.001, 1e9), skin.modulus_kpa);
    f(within("poisson", 0, 0.5), skin.poisson);
}

template <Is<scene::Grasp> Self, class F>
void each_field(Self& grasp, F&& f) {
    f("point", grasp.point);
    f("contact", grasp.contact);
}

template <Is<scene::Contact> Self, class F>
void each_field(Self& contact, F&& f) {
    f("patch", contact.patch);
    f(within("x_mm", -10000, 10000), contact.x_mm);
    f(within("y_mm", -10000, 10000), contact.y_mm);
    f(within("share", 0, 1), contact.share);
    f(within("radius_mm", 0.001, 1000), contact.radius_mm);
}

template <Is<scene::Touch> Self, class F>
void each_field(Self& touch, F&& f) {
    f("skin", touch.skin);
    f("edge", touch.edge);
    f("indenter", touch.indenter);
    f("grating", touch.grating);
    f("texture", touch.texture);
    f("grasp", touch.grasp);
}

template <Is<scene::Link> Self, class F>
void each_field(Self& link, F&& f) {
    f.arms(link.transport);
    f("keys", link.keys);
    f(within("tick_us", 1, 1000), link.tick_us);
    f(within("packet_ms", 0.001, 1000), link.packet_ms);
    f(within("packet_events", 1, 50000), link.packet_events);
    f(within("delivery_ms", 0, 10000), link.delivery_ms);
    f(within("stale_ms", 0, 1e6), link.stale_ms);
    f(within("heartbeat_ms", 0.001, 10000), link.heartbeat_ms);
    f(within("freeze_ms", 0.002, 1e6), link.freeze_ms);
    f(within("safe_ms", 0.002, 1e6), link.safe_ms);
    f("encoding", link.encoding);
    f(within("connect_s", 0, 1e9), link.connect_s);
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
    f(within("port", 0, 65535), at.port);
}

template <Is<scene::Serial> Self, class F>
void each_field(Self& serial, F&& f) {
    f("device", serial.device);
    f(within("baud", 1200, 4e6), serial.baud);
}

template <Is<scene::Channel> Self, class F>
void each_field(Self& channel, F&& f) {
    f(within("bandwidth_bps", 0, 1e15), channel.bandwidth_bps);
    f(within("latency_ms", 0, 10000), channel.latency_ms);
    f(within("jitter_ms", 0, 10000), channel.jitter_ms);
    f(within("loss", 0, 1), channel.loss);
    f(within("reorder", 0, 1), channel.reorder);
    f(within("duplicate", 0, 1), channel.duplicate);
    f(within("corrupt", 0, 1), channel.corrupt);
    f(within("fifo_events", 0, 1e9), channel.fifo_events);
    f("drop_policy", channel.drop_policy);
}

template <Is<scene::Bus> Self, class F>
void each_field(Self& bus, F&& f) {
    f(within("cycle_ns", 1, 1e9), bus.cycle_ns);
    f(within("rows", 1, 1e7), bus.rows);
    f(within("row_events", 1, 1e7), bus.row_events);
}

template <Is<scene::Decoder> Self, class F>
void each_field(Self& decoder, F&& f) {
    f.arms(decoder.kind);
    f("curve", decoder.curve);
    f("pooling", decoder.pooling);
    f("patch", decoder.patch);
    f("parts", decoder.parts);
    f("contact", decoder.contact);
    f("edge", decoder.edge);
}

template <Is<scene::ContactReadout> Self, class F>
void each_field(Self& contact, F&& f) {
    f(within("interval_ms", 0.001, 60000), contact.interval_ms);
}

template <Is<scene::EdgeReadout> Self, class F>
void each_field(Self& edge, F&& f) {
    f(within("settle_ms", 1, 60000), edge.settle_ms);
}

template <Is<scene::SlidingWindow> Self, class F>
void each_field(Self& decoder, F&& f) {
    f(within("window_ms", 0.001, 60000), decoder.window_ms);
}

template <Is<scene::Exponential> Self, class F>
void each_field(Self& decoder, F&& f) {
    f(within("time_constant_ms", 0.001, 60000), decoder.time_constant_ms);
}

template <Is<scene::Filter> Self, class F>
void each_field(Self& decoder, F&& f) {
    f("hold", decoder.hold);
    f("movement", decoder.movement);
    f("contact", decoder.contact);
}

template <Is<scene::Motion> Self, class F>
void each_field(Self& motion, F&& f) {
    f(within("speed_n_per_s", 1e-6, 1e6), motion.speed_n_per_s);
    f(within("drift_n2_per_s", 0, 1e6), motion.drift_n2_per_s);
}

template <Is<scene::Gain> Self, class F>
void each_field(Self& gain, F&& f) {
    f(within("onset_n", 0, 1e6), gain.onset_n);
    f(above("lambda_n", 0, 1e6), gain.lambda_n);
    f(above("limit_n", 0, 1e6), gain.limit_n);
    f("shape", gain.shape);
    f(within("upper_bound_sigmas", 0, 10), gain.upper_bound_sigmas);
    f("doubtful", gain.doubtful);
    f(within("saturated", 0, 1), gain.saturated);
    f("accept_unreachable_limit", gain.accept_unreachable_limit);
}

template <Is<Uncertainty> Self, class F>
void each_field(Self& uncertainty, F&& f) {
    f(within("gain", 0, 1), uncertainty.gain);
    f(within("common_gain", 0, 1), uncertainty.common_gain);
    f(within("share", 0, 10), uncertainty.share);
    f(within("share_time_s", 0.001, 1e9), uncertainty.share_time_s);
    f(within("offset_n", 0, 1e6), uncertainty.offset_n);
    f(within("hysteresis", 0, 1), uncertainty.hysteresis);
    f(within("adaptation", 0, 1), uncertainty.adaptation);
}

template <Is<scene::Hand> Self, class F>
void each_field(Self& hand, F&& f) {
    f(within("emg_rate_hz", 1, 100000), hand.emg_rate_hz);
    f(above("envelope_ms", 0, 1e6), hand.envelope_ms);
    f("user", hand.user);
    f("emg_table", hand.emg_table);
    f("motor", hand.motor);
    f("object", hand.object);
    f("safe_state", hand.safe_state);
    f("rearm", hand.rearm);
}

template <Is<User::Parameters> Self, class F>
void each_field(Self& user, F&& f) {
    f(within("close_at_s", 0, 1e9), user.close_at_s);
    f(within("close_for_s", 0, 1e9), user.close_for_s);
    f(within("hold_for_s", 0, 1e9), user.hold_for_s);
    f(within("open_for_s", 0, 1e9), user.open_for_s);
    f(within("effort", 0, 1), user.effort);
    f(above("ramp_s", 0, 1e9), user.ramp_s);
    f(within("hold_effort", 0, 1), user.hold_effort);
}

template <Is<scene::EmgTable> Self, class F>
void each_field(Self& table, F&& f) {
    f("path", table.path);
    f("column", table.column);
    f(within("rest_counts", -1e9, 1e9), table.rest_counts);
    f(above("full_scale_counts", 0, 1e9), table.full_scale_counts);
    f("between", table.between);
    f("time_column", table.time_column);
    f("time_unit", table.time_unit);
    f(within("rate_hz", 0.001, 1e6), table.rate_hz);
    f(within("begin_s", -9e9, 9e9), table.begin_s);
    f("unit", table.unit);
    f("signal", table.signal);
    f(above("full_scale_v", 0, 1e6), table.full_scale_v);
}

template <Is<scene::Motor> Self, class F>
void each_field(Self& motor, F&& f) {
    f(above("time_constant_ms", 0, 1e6), motor.time_constant_ms);
    f(above("speed_mm_per_s", 0, 1e6), motor.speed_mm_per_s);
    f(above("force_limit_n", 0, 1e6), motor.force_limit_n);
    f(below("dead_band", 0, 1), motor.dead_band);
}

template <Is<scene::Object> Self, class F>
void each_field(Self& object, F&& f) {
    f(above("stiffness_n_per_mm", 0, 1e6), object.stiffness_n_per_mm);
    f(within("distance_mm", 0, 1e6), object.distance_mm);
}

template <Is<scene::Record> Self, class F>
void each_field(Self& record, F&& f) {
    f("events", record.events);
    f("force", record.force);
    f("picture", record.picture);
}

template <Is<scene::Runtime> Self, class F>
void each_field(Self& runtime, F&& f) {
    f(within("threads", 0, 1024), runtime.threads);
    f(within("spikes_per_window", 1, 1e9), runtime.spikes_per_window);
    f(within("skip_scans_after_ms", 1, 60000), runtime.skip_scans_after_ms);
}

template <Is<scene::Trial> Self, class F>
void each_field(Self& trial, F&& f) {
    f("user", trial.user);
    f("emg", trial.emg);
    f("motor", trial.motor);
    f("object", trial.object);
    f("slippery", trial.slippery);
    f(within("connection_interval_ms", 0, 1000), trial.connection_interval_ms);
    f("send_on_delta", trial.send_on_delta);
}

template <Is<TrialUser::Parameters> Self, class F>
void each_field(Self& user, F&& f) {
    f(within("users", 1, 1e6), user.users);
    f(within("begin_s", 0, 100), user.begin_s);
    f(above("reach_effort", 0, 1), user.reach_effort);
    f(within("reach_spread", 0, 2), user.reach_spread);
    f(above("aim_n", 0, 1000), user.aim_n);
    f(within("aim_spread", 0, 2), user.aim_spread);
    f(within("user_spread", 0, 2), user.user_spread);
    f(within("reaction_ms", 0, 5000), user.reaction_ms);
    f(within("reaction_spread", 0, 2), user.reaction_spread);
    f(within("delay_ms", 0, 1000), user.delay_ms);
    f(above("contraction_ms", 0, 10000), user.contraction_ms);
    f(within("grip_s", 0, 100), user.grip_s);
    f(above("lift_s", 0, 100), user.lift_s);
    f(above("lift_mm_per_s", 0, 10000), user.lift_mm_per_s);
    f(within("settle_s", 0, 100), user.settle_s);
    f(within("hold_s", 0, 100), user.hold_s);
    f(within("slip_effort", 1, 100), user.slip_effort);
    f(above("patience_s", 0, 100), user.patience_s);
}

template <Is<SurfaceEmg::Parameters> Self, class F>
void each_field(Self& emg, F&& f) {
    f(above("centre_hz", 0, 50000), emg.centre_hz);
    f(above("bandwidth_hz", 0, 50000), emg.bandwidth_hz);
    f(within("rest_effort", 0, 1), emg.rest_effort);
}

template <Is<ProsthesisMotor::Parameters> Self, class F>
void each_field(Self& motor, F&& f) {
    f(above("aperture_mm", 0, 1e4), motor.aperture_mm);
    f(above("closing_s", 0, 100), motor.closing_s);
    f(above("force_limit_n", 0, 1e4), motor.force_limit_n);
    f(above("time_constant_ms", 0, 1e4), motor.time_constant_ms);
    f(below("dead_band", 0, 1), motor.dead_band);
}

template <Is<TrialObjects::Delicate> Self, class F>
void each_field(Self& object, F&& f) {
    f(above("stiffness_n_per_mm", 0, 1e4), object.stiffness_n_per_mm);
    f(within("stiffness_spread", 0, 2), object.stiffness_spread);
    f(above("breaking_force_n", 0, 1e4), object.breaking_force_n);
    f(within("breaking_spread", 0, 2), object.breaking_spread);
    f(within("least_breaking_force_n", 0, 1e4), object.least_breaking_force_n);
    f(above("weight_n", 0, 1e4), object.weight_n);
    f(above("friction", 0, 100), object.friction);
    f(within("distance_mm", 0, 1e4), object.distance_mm);
    f(within("distance_spread", 0, 2), object.distance_spread);
}

template <Is<TrialObjects::Slippery> Self, class F>
void each_field(Self& object, F&& f) {
    f(within("part", 0, 1), object.part);
    f(above("stiffness_n_per_mm", 0, 1e4), object.stiffness_n_per_mm);
    f(within("stiffness_spread", 0, 2), object.stiffness_spread);
    f(above("weight_n", 0, 1e4), object.weight_n);
    f(within("weight_spread", 0, 2), object.weight_spread);
    f(above("friction", 0, 100), object.friction);
    f(within("taper", 0, 1), object.taper);
    f(within("distance_mm", 0, 1e4), object.distance_mm);
    f(within("distance_spread", 0, 2), object.distance_spread);
    f(above("aim_factor", 0, 100), object.aim_factor);
}

template <Is<scene::SendOnDelta> Self, class F>
void each_field(Self& events, F&& f) {
    f(above("delta_n", 0, 1000), events.delta_n);
    f(above("time_constant_ms", 0, 10000), events.time_constant_ms);
    f(above("threshold_events", 0, 1e6), events.threshold_events);
}

}  // namespace afferent
