// A scene: everything that Afferent is told, as a value. Built in code, or read from text; both say the same.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/decoders/grip_estimator.hpp"
#include "afferent/decoders/output.hpp"
#include "afferent/decoders/uncertainty.hpp"
#include "afferent/encoders/calibration.hpp"
#include "afferent/encoders/outline.hpp"
#include "afferent/hand/grasp_contact.hpp"
#include "afferent/hand/grating.hpp"
#include "afferent/hand/indenter.hpp"
#include "afferent/hand/prosthesis_motor.hpp"
#include "afferent/hand/sensor.hpp"
#include "afferent/hand/sliding_edge.hpp"
#include "afferent/hand/surface_emg.hpp"
#include "afferent/hand/texture.hpp"
#include "afferent/hand/trial_object.hpp"
#include "afferent/hand/trial_user.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/io/files/time_unit.hpp"
#include "afferent/neurons/fixed_point.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/grip_guard.hpp"
#include "afferent/scene/scene_error.hpp"
#include "afferent/scene/setting.hpp"

namespace afferent {

// What a scene is made of. Members are called what they are called in the text, where proto/scene.proto tells
// what each means; the defaults are the same.
namespace scene {

// How many elements a scene may have, and how many afferents.
inline constexpr std::uint32_t most_addresses = 1U << 24;

inline constexpr double default_duration_s = 10;

enum class OutOfRange { clip, refuse };

// What there is between two rows of a table that are further apart than its samples are.
enum class Between { linear, hold };

struct StuckElement {
    std::uint32_t element = 0;
    double force_n = 0;
    bool operator==(const StuckElement&) const = default;
};

struct Sensor : afferent::Sensor::Parameters {
    double rate_hz = 200;
    std::vector<Calibration::Point> calibration = {};
    std::vector<std::uint32_t> dead_element = {};
    std::vector<StuckElement> stuck_element = {};
    double reference_v = 5;  // at the highest count, for tables in volts
    OutOfRange out_of_range = OutOfRange::clip;
    bool operator==(const Sensor&) const = default;
};

// Without a gain, gain and bias follow from the neuron's tuning.
struct Sustained {
    std::optional<double> gain_mv_per_n = {};
    std::optional<double> bias_mv = {};
    bool operator==(const Sustained&) const = default;
};

struct Transient {
    std::optional<double> gain_mv_s_per_n = {};
    std::optional<double> bias_mv = {};
    std::optional<double> corner_hz = {};
    bool operator==(const Transient&) const = default;
};

// It has a gain: no tuning gives it one.
struct Vibration {
    std::optional<double> gain_mv_s2_per_n = {};
    std::optional<double> bias_mv = {};
    double corner_hz = 250;
    bool operator==(const Vibration&) const = default;
};

using Encoder = std::variant<Sustained, Transient, Vibration>;

// Forces are grip forces; an element takes its share of them.
struct Tuning {
    RateKind rate = RateKind::steady;
    double rate_hz = 100;
    double force_n = 20;
    double begin_force_n = 0.3;
    double slope_n_per_s = 100;
    double begin_slope_n_per_s = 5;
    std::optional<double> other_rate_hz = {};
    bool operator==(const Tuning&) const = default;
};

enum class Form { automatic, sparse, dense };

// The neuron as a digital chip computes it (neurons/fixed_point.hpp).
struct FixedPoint {
    std::uint32_t tick_us = 100;
    std::uint32_t state_bits = 16;
    std::uint32_t decay_bits = 16;
    Rounding rounding = Rounding::half_even;
    bool operator==(const FixedPoint&) const = default;
};

struct Neuron : LifParameters {
    std::optional<FixedPoint> fixed_point = {};
    Tuning tuning = {};
    Form form = Form::automatic;
    bool operator==(const Neuron&) const = default;
};

// What an afferent reads of an element's force.
struct Weight {
    std::uint32_t element = 0;
    double weight = 1;
    bool operator==(const Weight&) const = default;
};

// A receptive field.
struct Field {
    std::vector<Weight> weight = {};
    bool operator==(const Field&) const = default;
};

struct Rectangle {
    double width_mm = 10;
    double height_mm = 10;
    bool operator==(const Rectangle&) const = default;
};

struct Ellipse {
    double width_mm = 10;
    double height_mm = 10;
    bool operator==(const Ellipse&) const = default;
};

struct Outline {
    std::variant<Rectangle, Ellipse> shape = {};
    double pitch_mm = 1;
    Place centre = {};  // on the map of the body
    bool operator==(const Outline&) const = default;
};

struct Afferents {
    double per_cm2 = 100;
    double jitter = 0;
    double field_sd_mm = 1;
    std::vector<Place> place = {};
    bool operator==(const Afferents&) const = default;
};

struct Normal {
    double mean = 1;
    double sd = 0;
    bool operator==(const Normal&) const = default;
};

struct LogNormal {
    double median = 1;
    double sigma = 0;
    bool operator==(const LogNormal&) const = default;
};

struct Uniform {
    double lowest = 1;
    double highest = 1;
    bool operator==(const Uniform&) const = default;
};

using Distribution = std::variant<Normal, LogNormal, Uniform>;

struct TimeClass {
    double part = 1;
    double tau_m = 1;
    double tau_g = 1;
    bool operator==(const TimeClass&) const = default;
};

// None: the same for all afferents.
struct Spread {
    std::optional<Distribution> gain = {};
    std::optional<Distribution> threshold = {};
    std::optional<Distribution> delta_g = {};
    std::optional<Distribution> field_sd = {};
    std::optional<Distribution> phase = {};
    std::vector<TimeClass> time_class = {};
    bool operator==(const Spread&) const = default;
};

// Of afferents in the human hand.
enum class Kind { sa1, ra, pc };

struct Patch {
    std::string name = {};
    std::uint32_t elements = 3;
    // How much of the grip force each element feels. None: the elements of all such patches share equally
    // what is left of it.
    std::vector<double> share = {};
    // The elements are those of the patch with this name.
    std::optional<std::string> elements_of = {};
    // One for each afferent. None, and no `afferents`: an afferent of its own for each element.
    std::vector<Field> field = {};
    // The elements are the cells of a grid within it.
    std::optional<Outline> outline = {};
    std::optional<Afferents> afferents = {};
    Spread spread = {};
    Sensor sensor = {};
    Encoder encoder = {};
    Neuron neuron = {};
    // For people to read, with all the numbers given: what they are called.
    std::optional<Kind> of_kind = {};
    bool operator==(const Patch&) const = default;
};

struct SimulatedHand {
    bool operator==(const SimulatedHand&) const = default;
};

using ProfilePoint = GripPoint;

struct Profile {
    std::vector<ProfilePoint> point = {};
    bool operator==(const Profile&) const = default;
};

// The unit of columns whose names have none.
enum class TableUnit { by_name, newtons, counts, volts };

struct Table {
    std::string path = {};
    std::vector<std::string> column = {};
    OutOfRange out_of_range = OutOfRange::clip;
    Between between = Between::linear;
    std::string time_column = {};  // empty: by its name
    TimeUnit time_unit = TimeUnit::found;
    std::optional<double> rate_hz = {};  // none: rows have times
    std::optional<double> begin_s = {};  // none: the first row's time, where it is 10 s or later
    TableUnit unit = TableUnit::by_name;
    bool operator==(const Table&) const = default;
};

struct StandardInput {
    std::vector<std::string> column = {};
    OutOfRange out_of_range = OutOfRange::clip;
    std::string time_column = {};
    TimeUnit time_unit = TimeUnit::found;
    TableUnit unit = TableUnit::by_name;
    bool operator==(const StandardInput&) const = default;
};

struct LinkSource {
    Table table = {};
    bool operator==(const LinkSource&) const = default;
};

// The program that embeds the scene pushes scans.
struct Pushed {
    bool operator==(const Pushed&) const = default;
};

using Edge = SlidingEdge::Parameters;
using Indenter = afferent::Indenter::Parameters;

struct Grating : afferent::Grating {
    Pad pad = {};
    double direction_deg = 0;
    double speed_mm_per_s = 20;
    Press press = {};
    bool operator==(const Grating&) const = default;
};

struct Texture : Roughness {
    Pad pad = {};
    double direction_deg = 0;
    double speed_mm_per_s = 20;
    Press press = {};
    bool operator==(const Texture&) const = default;
};

struct Contact {
    std::optional<std::string> patch = {};  // whose centre is its origin; none: that of the map
    double x_mm = 0;
    double y_mm = 0;
    // None: all contacts without share equally what is left of the grip force.
    std::optional<double> share = {};
    double radius_mm = 8;
    bool operator==(const Contact&) const = default;
};

struct Grasp {
    std::vector<ProfilePoint> point = {};
    std::vector<Contact> contact = {};
    bool operator==(const Grasp&) const = default;
};

// Stimuli on the skin, whose pressures add up.
struct Touch {
    ElasticSkin skin = {};
    std::vector<Edge> edge = {};
    std::vector<Indenter> indenter = {};
    std::vector<Grating> grating = {};
    std::vector<Texture> texture = {};
    std::vector<Grasp> grasp = {};
    bool operator==(const Touch&) const = default;
};

using Source = std::variant<SimulatedHand, Profile, Table, StandardInput, LinkSource, Pushed, Touch>;

// Samples come at the sensors' own rates, and not at times that others choose.
inline bool is_clocked(const Source& source) {
    return std::holds_alternative<SimulatedHand>(source) || std::holds_alternative<Profile>(source) ||
           std::holds_alternative<Touch>(source);
}

struct InProcess {
    bool operator==(const InProcess&) const = default;
};
struct UnixSocket {
    std::string path = "afferent.sock";
    bool operator==(const UnixSocket&) const = default;
};
struct Tcp {
    std::string host = "127.0.0.1";
    std::uint32_t port = 7450;
    bool operator==(const Tcp&) const = default;
};
struct Udp {
    std::string host = "127.0.0.1";
    std::uint32_t port = 7450;
    bool operator==(const Udp&) const = default;
};
struct Serial {
    std::string device = {};
    std::uint32_t baud = 921'600;
    bool operator==(const Serial&) const = default;
};
struct File {
    std::string path = {};
    bool operator==(const File&) const = default;
};
struct NamedPipes {
    std::string path = "afferent.pipe";
    bool operator==(const NamedPipes&) const = default;
};

using Transport = std::variant<InProcess, UnixSocket, Tcp, Udp, Serial, File, NamedPipes>;

enum class Encoding { rice, fixed_width };
enum class DropPolicy { oldest, newest };

struct Channel {
    double bandwidth_bps = 0;
    double latency_ms = 0;
    double jitter_ms = 0;
    double loss = 0;
    double reorder = 0;
    double duplicate = 0;
    double corrupt = 0;
    std::uint32_t fifo_events = 0;
    DropPolicy drop_policy = DropPolicy::oldest;
    bool operator==(const Channel&) const = default;
};

struct Bus {
    std::uint32_t cycle_ns = 100;
    std::uint32_t rows = 1;
    std::uint32_t row_events = 16;
    bool operator==(const Bus&) const = default;
};

struct Link {
    Transport transport = {};
    std::optional<std::string> keys = {};
    double tick_us = 100;
    double packet_ms = 5;
    std::uint32_t packet_events = 4096;
    double delivery_ms = 2;
    double stale_ms = 50;
    double heartbeat_ms = 25;
    double freeze_ms = 60;
    double safe_ms = 150;
    Encoding encoding = Encoding::rice;
    double connect_s = 10;
    std::optional<Channel> channel = {};
    std::optional<Bus> bus = {};
    bool operator==(const Link&) const = default;
};

struct SlidingWindow {
    double window_ms = 60;
    bool operator==(const SlidingWindow&) const = default;
};

struct Exponential {
    double time_constant_ms = 40;
    bool operator==(const Exponential&) const = default;
};

struct InverseInterval {
    bool operator==(const InverseInterval&) const = default;
};

struct Inversion {
    bool operator==(const Inversion&) const = default;
};

// How strongly a force moves; none: as the filter has it.
struct Motion {
    std::optional<double> speed_n_per_s = {};
    std::optional<double> drift_n2_per_s = {};
    bool operator==(const Motion&) const = default;
};

struct Filter {
    Motion hold = {};
    Motion movement = {};
    Motion contact = {};
    bool operator==(const Filter&) const = default;
};

// What has an estimate of its own besides the grip.
enum class Parts { none, patches, elements };

struct ContactReadout {
    double interval_ms = 10;
    bool operator==(const ContactReadout&) const = default;
};

struct EdgeReadout {
    double settle_ms = 200;
    bool operator==(const EdgeReadout&) const = default;
};

struct Decoder {
    std::variant<SlidingWindow, Exponential, InverseInterval, Inversion, Filter> kind = {};
    RateKind curve = RateKind::steady;
    Pooling pooling = Pooling::pooled;
    // The patches that it reads. None: every patch with a sustained encoder.
    std::vector<std::string> patch = {};
    Parts parts = Parts::none;
    // What is read out of each patch in two dimensions, where it is asked for.
    std::optional<ContactReadout> contact = {};
    std::optional<EdgeReadout> edge = {};
    bool operator==(const Decoder&) const = default;
};

struct Gain : EmgGain::Parameters {
    // Although the sensors or the rates cannot bring the gain to 0 at limit_n (gain_reach.hpp).
    bool accept_unreachable_limit = false;
    bool operator==(const Gain&) const = default;
};

// Commands as a table in a file.
struct CommandFile {
    std::string path = {};
    bool operator==(const CommandFile&) const = default;
};

// What an estimate drives besides the gain.
using Output = std::variant<CommandFile>;

enum class EmgUnit { by_name, counts, volts };
enum class EmgSignal { automatic, raw, envelope };

struct EmgTable {
    std::string path = {};
    std::string column = "emg";
    std::optional<double> rest_counts = {};
    double full_scale_counts = 500;
    Between between = Between::linear;
    std::string time_column = {};
    TimeUnit time_unit = TimeUnit::found;
    std::optional<double> rate_hz = {};
    std::optional<double> begin_s = {};
    EmgUnit unit = EmgUnit::by_name;
    EmgSignal signal = EmgSignal::automatic;
    std::optional<double> full_scale_v = {};  // none: by the recording itself
    bool operator==(const EmgTable&) const = default;
};

struct Motor {
    double time_constant_ms = 60;
    double speed_mm_per_s = 60;
    double force_limit_n = 25;
    double dead_band = 0.02;
    bool operator==(const Motor&) const = default;
};

struct Object {
    double stiffness_n_per_mm = 0.6;
    double distance_mm = 20;
    bool operator==(const Object&) const = default;
};

struct Hand {
    double emg_rate_hz = 1000;
    double envelope_ms = 40;
    User::Parameters user = {};
    std::optional<EmgTable> emg_table = {};
    Motor motor = {};
    Object object = {};
    SafeState safe_state = SafeState::hold;
    Rearm rearm = Rearm::new_session;
    bool operator==(const Hand&) const = default;
};

struct Record {
    bool events = true;
    bool force = true;
    bool picture = true;
    bool operator==(const Record&) const = default;
};

struct Runtime {
    std::uint32_t threads = 0;
    std::uint32_t spikes_per_window = 1000;
    std::optional<double> skip_scans_after_ms = {};
    bool operator==(const Runtime&) const = default;
};

struct SendOnDelta {
    double delta_n = 0.1;
    double time_constant_ms = 20;
    double threshold_events = 2;
    bool operator==(const SendOnDelta&) const = default;
};

struct Trial {
    TrialUser::Parameters user = {};
    SurfaceEmg::Parameters emg = {};
    ProsthesisMotor::Parameters motor = {};
    TrialObjects::Delicate object = {};
    TrialObjects::Slippery slippery = {};
    double connection_interval_ms = 30;
    SendOnDelta send_on_delta = {};
    bool operator==(const Trial&) const = default;
};

}  // namespace scene

// The defaults are the paper's: nine elements on three fingers, a simulated hand.
//
//     Scene scene;
//     scene.patches = {{.name = "thumb", .elements = 3}};
//     scene.link.transport = scene::Tcp{.port = 7450};
//     scene.check();
struct Scene {
    std::string name = {};
    // None: as long as the table of forces, where there is one, and otherwise 10. A plan's scene always has
    // it.
    std::optional<double> duration_s = {};
    std::uint64_t seed = 1;
    std::vector<scene::Patch> patches = {{.name = "thumb"}, {.name = "index"}, {.name = "middle"}};
    scene::Source source = {};
    scene::Link link = {};
    scene::Decoder decoder = {};
    scene::Gain gain = {};
    Uncertainty uncertainty = {};
    std::vector<scene::Output> output = {};
    scene::Hand hand = {};
    scene::Record record = {};
    scene::Runtime runtime = {};
    std::optional<scene::Trial> trial = {};

    // Not part of the scene itself: its name in messages, and the folder that its paths are relative to.
    std::string file = "scene";
    std::filesystem::path folder = ".";

    // Read and checked. Throw SceneError, which tells file, line, column, field and rule of everything that
    // is wrong. Settings replace what the text says, in their order.
    static Scene from_file(const std::filesystem::path& file, std::span<const Setting> settings = {});
    static Scene from_text(std::string_view text, std::string file = "scene",
                           std::filesystem::path folder = ".", std::span<const Setting> settings = {});
    // This scene with these settings in place, checked. Throws SceneError.
    Scene with(std::span<const Setting> settings) const;
    // What differs from the defaults, as from_text reads it back to the same scene.
    enum class TextLayout { one_line, field_a_line };
    std::string text(TextLayout layout = TextLayout::one_line) const;

    // Throws SceneError, which names the path of each field that is wrong, as in "patch[0].neuron.tau_m_ms",
    // and the rule that it breaks. What passes can be planned, and run.
    void check() const;

    TimePoint end() const;
    std::filesystem::path resolve(const std::string& path) const { return folder / path; }

    // The same for two sides that can talk to each other: it covers patches, neurons, link, seed and
    // duration, but not where they meet, what the scene is called, and how it is recorded or carried out.
    std::uint64_t fingerprint() const;
    // The same for each of its fields and their fields, by name: "seed", "link.packet_ms", "patch.neuron".
    // Fields that are at their default are not among them; those of all patches count together.
    std::map<std::string, std::uint32_t> part_fingerprints() const;
};

// From seconds or milliseconds, to the nearest nanosecond.
Duration from_seconds(double seconds);
Duration from_milliseconds(double milliseconds);

}  // namespace afferent
