// The decoder of a scene, its read-outs and its gain. Included with scene.hpp by whoever builds a scene.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/emg_gain.hpp"
#include "afferent/decoders/uncertainty.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

void each_field(Is<Uncertainty> auto& uncertainty, auto&& f) {
    f(within("gain", 0, 1), uncertainty.gain);
    f(within("common_gain", 0, 1), uncertainty.common_gain);
    f(within("share", 0, 10), uncertainty.share);
    f(within("share_time_s", 0.001, 1e9), uncertainty.share_time_s);
    f(within("offset_n", 0, 1e6), uncertainty.offset_n);
    f(within("hysteresis", 0, 1), uncertainty.hysteresis);
    f(within("adaptation", 0, 1), uncertainty.adaptation);
}

namespace scene {

struct SlidingWindow {
    static constexpr const char* alternative = "sliding_window";
    double window_ms = 60;
    bool operator==(const SlidingWindow&) const = default;
    static void fields(auto& self, auto&& f) { f(within("window_ms", 0.001, 60000), self.window_ms); }
};

struct Exponential {
    static constexpr const char* alternative = "exponential";
    double time_constant_ms = 40;
    bool operator==(const Exponential&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("time_constant_ms", 0.001, 60000), self.time_constant_ms);
    }
};

struct InverseInterval {
    static constexpr const char* alternative = "interval";
    bool operator==(const InverseInterval&) const = default;
    static void fields(auto&, auto&&) {}
};

struct Inversion {
    static constexpr const char* alternative = "inversion";
    bool operator==(const Inversion&) const = default;
    static void fields(auto&, auto&&) {}
};

// Overrides of the filter's model of a motion; absent values are the filter's own.
struct Motion {
    std::optional<double> speed_n_per_s = {};
    std::optional<double> drift_n2_per_s = {};
    bool operator==(const Motion&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("speed_n_per_s", 1e-6, 1e6), self.speed_n_per_s);
        f(within("drift_n2_per_s", 0, 1e6), self.drift_n2_per_s);
    }
};

struct Filter {
    static constexpr const char* alternative = "filter";
    Motion hold = {};
    Motion movement = {};
    Motion contact = {};
    bool operator==(const Filter&) const = default;
    static void fields(auto& self, auto&& f) {
        f("hold", self.hold);
        f("movement", self.movement);
        f("contact", self.contact);
    }
};

// What has force estimates of its own besides the whole grip.
enum class Parts { none, patches, elements };

struct ContactReadout {
    double interval_ms = 10;
    bool operator==(const ContactReadout&) const = default;
    static void fields(auto& self, auto&& f) { f(within("interval_ms", 0.001, 60000), self.interval_ms); }
};

struct EdgeReadout {
    double settle_ms = 200;
    bool operator==(const EdgeReadout&) const = default;
    static void fields(auto& self, auto&& f) { f(within("settle_ms", 1, 60000), self.settle_ms); }
};

struct TextureReadout {
    double window_ms = 500;
    bool operator==(const TextureReadout&) const = default;
    static void fields(auto& self, auto&& f) { f(within("window_ms", 20, 4000), self.window_ms); }
};

struct Decoder {
    std::variant<SlidingWindow, Exponential, InverseInterval, Inversion, Filter> kind = {};
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    // The patches that it reads. Empty: every patch with a sustained encoder.
    std::vector<std::string> patch = {};
    Parts parts = Parts::none;
    // The read-outs of each patch, if any.
    std::optional<ContactReadout> contact = {};
    std::optional<EdgeReadout> edge = {};
    std::optional<TextureReadout> texture = {};
    bool operator==(const Decoder&) const = default;
    static void fields(auto& self, auto&& f) {
        f.arms(self.kind);
        f("curve", self.curve);
        f("pooling", self.pooling);
        f("patch", self.patch);
        f("parts", self.parts);
        f("contact", self.contact);
        f("edge", self.edge);
        f("texture", self.texture);
    }
};

// The brake at a contact (decoders/contact_reflex.hpp), by the motor of the scene's hand.
struct Brake {
    double command = 1;
    double impulse_ms = 40;
    double contact_n = 0.3;
    double release_n = 0.1;
    double release_ms = 200;
    bool operator==(const Brake&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("command", 0, 1), self.command);
        f(within("impulse_ms", 0, 1000), self.impulse_ms);
        f(above("contact_n", 0, 1e6), self.contact_n);
        f(within("release_n", 0, 1e6), self.release_n);
        f(within("release_ms", 0, 60000), self.release_ms);
    }
};

// The closing pulse at a slip (decoders/slip_pulse.hpp).
struct SlipPulse {
    double command = 1;
    double pulse_ms = 60;
    double fall_n = 0.1;
    double fall_sigmas = 1;
    double within_ms = 100;
    double settle_ms = 400;
    std::uint32_t most = 5;
    bool operator==(const SlipPulse&) const = default;
    static void fields(auto& self, auto&& f) {
        f(above("command", 0, 1), self.command);
        f(above("pulse_ms", 0, 1000), self.pulse_ms);
        f(above("fall_n", 0, 1e6), self.fall_n);
        f(within("fall_sigmas", 0, 100), self.fall_sigmas);
        f(within("within_ms", 1, 10000), self.within_ms);
        f(within("settle_ms", 0, 10000), self.settle_ms);
        f(within("most", 1, 1000), self.most);
    }
};

struct Gain : EmgGain::Parameters {
    // Accepts a scene in which sensors or rates cannot bring the gain to 0 at limit_n.
    bool accept_unreachable_limit = false;
    std::optional<Brake> brake = {};
    double lead_ms = 0;
    std::optional<SlipPulse> pulse = {};
    bool operator==(const Gain&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("onset_n", 0, 1e6), self.onset_n);
        f(above("lambda_n", 0, 1e6), self.lambda_n);
        f(above("limit_n", 0, 1e6), self.limit_n);
        f("shape", self.shape);
        f(within("upper_bound_sigmas", 0, 10), self.upper_bound_sigmas);
        f("doubtful", self.doubtful);
        f(within("saturated", 0, 1), self.saturated);
        f("accept_unreachable_limit", self.accept_unreachable_limit);
        f("brake", self.brake);
        f(within("lead_ms", 0, 1000), self.lead_ms);
        f("pulse", self.pulse);
    }
};

}  // namespace scene

struct Plan;
struct Scene;
class PlanItems;
class SceneFaults;

// Whether the decoder is the filter, which models the sensors' uncertainty and reads transient afferents.
bool is_filter(const scene::Decoder& decoder);

void check(const scene::Decoder& decoder, const Scene& scene, SceneFaults& faults);
void check_gain(const Scene& scene, SceneFaults& faults);
void add_decoder_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
