#include "afferent/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/decoders/spike_rate.hpp"
#include "afferent/hand/emg_envelope.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/form.hpp"
#include "afferent/scene/parameters.hpp"
#include "afferent/scene/scene_link.hpp"

namespace afferent {
namespace {

constexpr double longest_s = 1e9;
constexpr std::uint32_t most_addresses = 1U << 24;

std::string in_list(const std::string& field, int index) { return field + "[" + std::to_string(index) + "]"; }

// The patch with what it does not say itself taken from every_patch. A list of its own replaces the shared
// one.
proto::Patch filled_in(const proto::Patch& shared, const proto::Patch& own) {
    proto::Patch patch = shared;
    if (own.share_size()) patch.clear_share();
    if (own.sensor().calibration_size()) patch.mutable_sensor()->clear_calibration();
    if (own.sensor().dead_element_size()) patch.mutable_sensor()->clear_dead_element();
    if (own.sensor().stuck_element_size()) patch.mutable_sensor()->clear_stuck_element();
    patch.MergeFrom(own);
    return patch;
}

void fill_in_patches(proto::Scene& scene) {
    if (scene.patch_size() == 0)
        for (const char* name : {"thumb", "index", "middle"}) scene.add_patch()->set_name(name);
    for (proto::Patch& patch : *scene.mutable_patch()) patch = filled_in(scene.every_patch(), patch);
    scene.clear_every_patch();
}

// Checks and fills in the patches of a scene, in the order in which they build on each other: names, then
// elements, then the shares of the grip force, then what each patch is made of.
class Patches {
  public:
    Patches(SceneText& text, const proto::Scene& scene) : text_(text), scene_(scene) {}

    std::vector<Patch> filled_in() {
        std::vector<Patch> patches;
        std::set<std::string> names;
        std::uint64_t first = 0;
        for (int i = 0; i < scene_.patch_size(); ++i) {
            const proto::Patch& given = scene_.patch(i);
            const std::string path = in_list("patch", i);
            Patch patch{};
            patch.name = given.name();
            patch.first = static_cast<Address>(first);
            patch.reads = static_cast<std::size_t>(i);
            if (patch.name.empty()) text_.refuse(path, "a patch must have a name");
            if (!names.insert(patch.name).second)
                text_.refuse(path + ".name", about(patch) + ": another patch has this name");
            patch.elements = given.elements();
            if (given.has_elements_of()) find_elements(patch, path, given, patches);
            if (patch.elements == 0)
                text_.refuse(path + ".elements", about(patch) + ": elements must be > 0, is 0");
            first += patch.elements;
            if (first > most_addresses) {
                text_.refuse(path + ".elements",
                             "a scene has at most " + std::to_string(most_addresses) + " addresses");
                break;
            }
            patches.push_back(std::move(patch));
        }
        text_.throw_if_refused();
        share_the_grip(patches);
        for (std::size_t i = 0; i < patches.size(); ++i) make(patches, i);
        text_.throw_if_refused();
        return patches;
    }

  private:
    static std::string about(const Patch& patch) { return "patch \"" + patch.name + "\""; }

    void find_elements(Patch& patch, const std::string& path, const proto::Patch& given,
                       const std::vector<Patch>& before) {
        const auto found = std::find_if(before.begin(), before.end(), [&](const Patch& other) {
            return other.name == given.elements_of() &&
                   other.owns_elements(static_cast<std::size_t>(&other - before.data()));
        });
        if (found == before.end()) {
            text_.refuse(path + ".elements_of",
                         about(patch) + ": elements_of must name an earlier patch with " +
                             "elements of its own, is \"" + given.elements_of() + "\"");
            return;
        }
        patch.reads = static_cast<std::size_t>(found - before.begin());
        patch.elements = found->elements;
    }

    void share_the_grip(std::vector<Patch>& patches) {
        double given_share = 0;
        std::uint32_t without = 0;
        for (std::size_t i = 0; i < patches.size(); ++i) {
            if (!patches[i].owns_elements(i)) continue;
            const auto& shares = scene_.patch(static_cast<int>(i)).share();
            const std::string path = in_list("patch", static_cast<int>(i)) + ".share";
            for (const double share : shares) {
                if (!(share >= 0 && share <= 1))
                    text_.refuse(path,
                                 about(patches[i]) + ": share must be 0 to 1, is " + std::to_string(share));
                given_share += share;
            }
            if (shares.empty())
                without += patches[i].elements;
            else if (static_cast<std::uint32_t>(shares.size()) != patches[i].elements)
                text_.refuse(path, about(patches[i]) + ": share must be given once for each of the " +
                                       std::to_string(patches[i].elements) + " elements, is given " +
                                       std::to_string(shares.size()) + " times");
            patches[i].share.assign(shares.begin(), shares.end());
        }
        // A sum of rounded decimals may be a little above 1.
        if (given_share > 1 + 1e-9)
            text_.refuse("patch[0].share",
                         "all shares must add up to at most 1, add up to " + std::to_string(given_share));
        text_.throw_if_refused();
        for (std::size_t i = 0; i < patches.size(); ++i) {
            Patch& patch = patches[i];
            if (!patch.owns_elements(i))
                patch.share = patches[patch.reads].share;
            else if (patch.share.empty())
                patch.share.assign(patch.elements, std::max(0.0, 1 - given_share) / without);
        }
    }

    void make(std::vector<Patch>& patches, std::size_t index) {
        Patch& patch = patches[index];
        const proto::Patch& given = scene_.patch(static_cast<int>(index));
        const std::string path = in_list("patch", static_cast<int>(index));
        if (patch.owns_elements(index))
            make_sensor(patch, given.sensor(), path + ".sensor");
        else if (has_own_sensor(index))
            text_.refuse(path + ".sensor",
                         about(patch) + ": a patch with elements_of has no sensor of its own");
        make_neuron(patch, given, path);
    }

    // As written: a sensor that every_patch gives is not this patch's own.
    bool has_own_sensor(std::size_t index) const {
        return text_.scene().patch(static_cast<int>(index)).has_sensor();
    }

    void make_sensor(Patch& patch, const proto::Sensor& sensor, const std::string& path) {
        patch.rate_hz = sensor.rate_hz();
        patch.sensor = sensor_parameters(sensor);
        patch.refuse_out_of_range = sensor.out_of_range() == proto::REFUSE;
        text_.check(path, about(patch), [&] {
            require(patch.rate_hz >= 1e-3 && patch.rate_hz <= 1e6, "rate_hz", "0.001 to 1000000",
                    patch.rate_hz);
            const Sensor made(patch.sensor);
            std::vector<Calibration::Point> points;
            for (const auto& point : sensor.calibration())
                points.push_back({point.counts(), point.force_n()});
            if (!points.empty()) patch.calibration.emplace(std::move(points));
            for (const std::uint32_t element : sensor.dead_element()) {
                require(element < patch.elements, "dead_element", "below the number of elements", element);
                patch.dead.push_back(element);
            }
            for (const auto& stuck : sensor.stuck_element()) {
                require(stuck.element() < patch.elements, "stuck_element.element",
                        "below the number of elements", stuck.element());
                require(made.within_range(stuck.force_n()), "stuck_element.force_n", "0 to full_scale_n",
                        stuck.force_n());
                patch.stuck_n.emplace_back(stuck.element(), stuck.force_n());
            }
        });
    }

    void make_neuron(Patch& patch, const proto::Patch& given, const std::string& path) {
        const bool transient = given.encoder().has_transient();
        patch.neuron = neuron_parameters(given.neuron());
        patch.target = tuning_target(given.neuron().tuning(), transient, patch.mean_share());
        const std::size_t refused_before = refused_;
        check(path + ".neuron", patch, [&] { patch.neuron.check(); });

        const bool has_gain = transient ? given.encoder().transient().has_gain_mv_s_per_n()
                                        : given.encoder().sustained().has_gain_mv_per_n();
        double gain = transient ? given.encoder().transient().gain_mv_s_per_n()
                                : given.encoder().sustained().gain_mv_per_n();
        double bias =
            transient ? given.encoder().transient().bias_mv() : given.encoder().sustained().bias_mv();
        if (!has_gain) {
            const bool has_bias = transient ? given.encoder().transient().has_bias_mv()
                                            : given.encoder().sustained().has_bias_mv();
            if (has_bias)
                text_.refuse(path + ".encoder",
                             about(patch) + ": encoder: a bias without a gain; tuning solves both");
            // What the neuron itself refuses cannot be tuned.
            if (refused_ == refused_before) {
                check(path + ".neuron.tuning", patch, [&] {
                    require(patch.mean_share() > 0, "force_n", "felt by elements with a share > 0",
                            patch.mean_share());
                    const Tuned tuned = tune(patch.neuron, patch.target);
                    gain = tuned.gain;
                    bias = tuned.bias_mv;
                    patch.neuron.delta_g = tuned.delta_g;
                });
            }
        }
        if (refused_ != refused_before) return;
        check(path + (transient ? ".encoder.transient" : ".encoder.sustained"), patch, [&] {
            if (transient) {
                patch.encoder = Transient::Parameters{gain, bias};
                (void)Transient(std::get<Transient::Parameters>(patch.encoder));
            } else {
                patch.encoder = Sustained::Parameters{gain, bias};
                (void)Sustained(std::get<Sustained::Parameters>(patch.encoder));
            }
        });
    }

    // As SceneText::check, and counts what was refused.
    void check(const std::string& path, const Patch& patch, const std::function<void()>& rule) {
        text_.check(path, about(patch), [&] {
            try {
                rule();
            } catch (const ParameterError&) {
                ++refused_;
                throw;
            }
        });
    }

    SceneText& text_;
    const proto::Scene& scene_;
    std::size_t refused_ = 0;
};

void check_link(SceneText& text, const proto::Link& link) {
    text.check("link", "", [&] {
        require(link.tick_us() >= 1 && link.tick_us() <= 1000, "tick_us", "1 to 1000", link.tick_us());
        require(link.packet_ms() > 0 && link.packet_ms() <= 1000, "packet_ms", "> 0 and <= 1000",
                link.packet_ms());
        const LinkTiming timing = link_timing(link);
        if (timing.packet % timing.tick != 0ns)
            throw ParameterError("packet_ms", "a multiple of tick_us", link.packet_ms());
        require(link.packet_events() >= 1 && link.packet_events() <= 50'000, "packet_events", "1 to 50000",
                link.packet_events());
        require(link.delivery_ms() >= 0 && link.delivery_ms() <= 10'000, "delivery_ms", "0 to 10000",
                link.delivery_ms());
        require(link.heartbeat_ms() >= link.packet_ms() && link.heartbeat_ms() <= 10'000, "heartbeat_ms",
                ">= packet_ms and <= 10000", link.heartbeat_ms());
        require(link.stale_ms() >= 0 && link.stale_ms() <= 1e6, "stale_ms", "0 to 1000000", link.stale_ms());
        require(link.freeze_ms() >= 2 * link.heartbeat_ms(), "freeze_ms", "at least twice heartbeat_ms",
                link.freeze_ms());
        require(link.safe_ms() > link.freeze_ms(), "safe_ms", "> freeze_ms", link.safe_ms());
        require(link.connect_s() >= 0, "connect_s", ">= 0", link.connect_s());
        if (link.has_tcp()) require(link.tcp().port() <= 65'535, "tcp.port", "0 to 65535", link.tcp().port());
        if (link.has_udp()) require(link.udp().port() <= 65'535, "udp.port", "0 to 65535", link.udp().port());
        if (link.has_serial()) {
            require(link.serial().baud() >= 1200 && link.serial().baud() <= 4'000'000, "serial.baud",
                    "1200 to 4000000", link.serial().baud());
            if (link.serial().device().empty())
                throw ParameterError("serial.device", "the path of a tty", "empty");
            if (link.keys().empty())
                throw ParameterError("serial", "on a link with keys, which afferent keys makes", "without");
        }
        if (link.has_keys() && link.keys().empty())
            throw ParameterError("keys", "the path of a folder", "empty");
        if (link.has_keys() && !link.has_tcp() && !link.has_udp() && !link.has_serial())
            throw ParameterError("keys", "on a link that can leave the machine: tcp, udp or serial",
                                 "on another");
        if (link.has_file() && link.file().path().empty())
            throw ParameterError("file.path", "the path of a recording", "empty");
        // The longest path that a socket's address holds.
        if (link.has_unix_socket() &&
            (link.unix_socket().path().empty() || link.unix_socket().path().size() > 107))
            throw ParameterError("unix_socket.path", "1 to 107 characters",
                                 "\"" + link.unix_socket().path() + "\"");
    });
}

// What is sent at once has to fit into one datagram.
void check_datagrams(SceneText& text, const Scene& scene) {
    const proto::Link& link = scene.description().link();
    if (!over_datagrams(link)) return;
    const std::string limit = std::to_string(max_datagram_frame_bytes) + " bytes, which a datagram holds";
    text.check("link", "", [&] {
        require(most_packet_bytes(packet_layout(scene)) <= max_datagram_frame_bytes, "packet_events",
                ("so few that a packet takes at most " + limit).c_str(), link.packet_events());
        constexpr std::size_t framing_bytes = 64;
        if (hand_has_samples(scene))
            require(framing_bytes + scene.elements() * sizeof(double) <= max_datagram_frame_bytes, "elements",
                    ("so few that the hand's samples take at most " + limit).c_str(), scene.elements());
    });
}

void check_channel(SceneText& text, const proto::Link& link) {
    if (!link.has_channel()) return;
    text.check("link.channel", "", [&] {
        if (in_process(link))
            throw ParameterError("channel", "on a link with packets, tcp, unix_socket, udp or serial",
                                 "in process");
        const double longest_ms = 10'000;
        require(link.channel().latency_ms() <= longest_ms, "latency_ms", "at most 10000",
                link.channel().latency_ms());
        require(link.channel().jitter_ms() <= longest_ms, "jitter_ms", "at most 10000",
                link.channel().jitter_ms());
        channel_parameters(link.channel(), 0).check();
    });
    // `afferent channel` stands next to the hand.
    text.check("link", "", [&] {
        for (const auto& [field, port] : {std::pair("tcp.port", link.has_tcp() ? link.tcp().port() : 0),
                                          std::pair("udp.port", link.has_udp() ? link.udp().port() : 0)})
            require(port < 65'535, field, "below 65535 where there is a channel, which takes the next one",
                    port);
        const std::string path = link.has_unix_socket() ? link.unix_socket().path() : "";
        require(path.size() <= 99, "unix_socket.path", "at most 99 characters where there is a channel",
                static_cast<double>(path.size()));
    });
}

void check_decoder(SceneText& text, const proto::Decoder& decoder, const std::vector<Patch>& patches) {
    text.check("decoder", "", [&] {
        require(decoder.window_ms() > 0 && decoder.window_ms() <= 60'000, "window_ms", "> 0 and <= 60000",
                decoder.window_ms());
        for (const std::string& name : decoder.patch()) {
            const auto found =
                std::find_if(patches.begin(), patches.end(), [&](const Patch& p) { return p.name == name; });
            if (found == patches.end() || !found->sustained())
                throw ParameterError("patch", "a patch with a sustained encoder", "\"" + name + "\"");
        }
    });
}

void check_source(SceneText& text, const proto::Source& source) {
    text.check("source", "", [&] {
        if (source.has_table() && source.table().path().empty())
            throw ParameterError("table.path", "the path of a table", "empty");
        if (source.has_link() && source.link().table().path().empty())
            throw ParameterError("link.table.path", "the path of a table", "empty");
        if (source.has_profile()) {
            double before = -1;
            if (source.profile().point().empty())
                throw ParameterError("profile.point", "given at least once", "none");
            for (const auto& point : source.profile().point()) {
                require(point.time_s() >= 0 && point.time_s() > before && point.time_s() <= longest_s,
                        "profile.point.time_s", ">= 0 and increasing", point.time_s());
                require(point.force_n() >= 0, "profile.point.force_n", ">= 0", point.force_n());
                before = point.time_s();
            }
        }
    });
}

void check_hand(SceneText& text, const proto::Scene& scene) {
    const proto::Hand& hand = scene.hand();
    text.check("gain", "", [&] { (void)EmgGain(gain_parameters(scene.gain())); });
    text.check("hand", "", [&] {
        require(hand.emg_rate_hz() >= 1 && hand.emg_rate_hz() <= 100'000, "emg_rate_hz", "1 to 100000",
                hand.emg_rate_hz());
        require(hand.envelope_ms() > 0, "envelope_ms", "> 0", hand.envelope_ms());
        (void)Gripper(gripper_parameters(hand));
        if (hand.has_emg_table() && hand.emg_table().path().empty())
            throw ParameterError("emg_table.path", "the path of a table", "empty");
        require(hand.emg_table().full_scale_counts() > 0, "emg_table.full_scale_counts", "> 0",
                hand.emg_table().full_scale_counts());
    });
    text.check("hand.user", "", [&] { (void)User(user_parameters(hand.user()), 0); });
}

}  // namespace

double Patch::mean_share() const noexcept {
    double sum = 0;
    for (const double value : share) sum += value;
    return sum / elements;
}

double Patch::gain() const noexcept {
    const auto* parameters = std::get_if<Sustained::Parameters>(&encoder);
    return parameters ? parameters->gain_mv_per_n : std::get<Transient::Parameters>(encoder).gain_mv_s_per_n;
}

double Patch::bias_mv() const noexcept {
    return std::visit([](const auto& parameters) { return parameters.bias_mv; }, encoder);
}

Scene Scene::from_file(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text(largest_scene_text + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!in.is_open() || in.bad()) throw SceneError({file.string() + ": cannot be read"});
    text.resize(static_cast<std::size_t>(in.gcount()));
    return from_text(text, file.string(), file.parent_path());
}

Scene Scene::from_text(std::string_view text, std::string name, std::filesystem::path folder) {
    SceneText parsed(text, name);
    return Scene(parsed, std::move(name), std::move(folder));
}

Scene::Scene(SceneText& text, std::string name, std::filesystem::path folder)
    : description_(text.scene()), name_(std::move(name)), folder_(std::move(folder)) {
    text.check("", "", [&] {
        require(description_.duration_s() > 0 && description_.duration_s() <= longest_s, "duration_s",
                "> 0 and <= 1e9", description_.duration_s());
    });
    check_link(text, description_.link());
    check_channel(text, description_.link());
    check_source(text, description_.source());
    check_hand(text, description_);
    fill_in_patches(description_);
    patches_ = Patches(text, description_).filled_in();
    check_decoder(text, description_.decoder(), patches_);
    addresses_ = patches_.back().first + patches_.back().elements;
    if (description_.link().has_bus())
        text.check("link.bus", "", [&] { bus_parameters(description_.link().bus(), addresses_).check(); });
    text.throw_if_refused();
    duration_ = from_seconds(description_.duration_s());
    check_datagrams(text, *this);
    for (std::size_t i = 0; i < patches_.size(); ++i)
        text.check(in_list("patch", static_cast<int>(i)) + ".neuron", "patch \"" + patches_[i].name + "\"",
                   [&] { (void)form_of(*this, patches_[i]); });
    text.throw_if_refused();
}

std::uint32_t Scene::elements() const noexcept {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < patches_.size(); ++i)
        if (patches_[i].owns_elements(i)) sum += patches_[i].elements;
    return sum;
}

std::string Scene::text() const {
    google::protobuf::TextFormat::Printer printer;
    printer.SetSingleLineMode(true);
    std::string text;
    printer.PrintToString(description_, &text);
    return text;
}

std::uint64_t Scene::fingerprint() const {
    proto::Scene agreed = description_;
    agreed.clear_name();
    agreed.clear_record();
    agreed.clear_runtime();
    agreed.mutable_link()->clear_transport();
    agreed.mutable_link()->clear_keys();
    agreed.mutable_link()->clear_connect_s();
    if (agreed.hand().has_emg_table()) agreed.mutable_hand()->mutable_emg_table()->clear_path();
    if (agreed.source().has_table()) agreed.mutable_source()->mutable_table()->clear_path();
    if (agreed.source().has_link()) agreed.mutable_source()->mutable_link()->mutable_table()->clear_path();
    std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
    for (const char byte : agreed.SerializeAsString())
        hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
    return hash;
}

void Scene::set_table(const std::string& path) {
    const std::string absolute = std::filesystem::absolute(path).string();
    proto::Source& source = *description_.mutable_source();
    if (source.has_link())
        source.mutable_link()->mutable_table()->set_path(absolute);
    else
        source.mutable_table()->set_path(absolute);
}

void Scene::set_emg_table(const std::string& path) {
    description_.mutable_hand()->mutable_emg_table()->set_path(std::filesystem::absolute(path).string());
}

Duration from_seconds(double seconds) { return rounded(Seconds(seconds)); }
Duration from_milliseconds(double milliseconds) { return rounded(Milliseconds(milliseconds)); }

LinkTiming link_timing(const proto::Link& link) {
    return {rounded(std::chrono::duration<double, std::micro>(link.tick_us())),
            from_milliseconds(link.packet_ms()),
            from_milliseconds(link.delivery_ms()),
            from_milliseconds(link.delivery_ms() + link.stale_ms()),
            from_milliseconds(link.heartbeat_ms()),
            from_milliseconds(link.freeze_ms()),
            from_milliseconds(link.safe_ms())};
}

}  // namespace afferent
