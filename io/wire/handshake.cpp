#include "afferent/io/wire/handshake.hpp"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "afferent/proto/aer.pb.h"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

template <class Number, class... Format>
std::string digits(Number number, Format... format) {
    std::array<char, 32> text;
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number, format...).ptr};
}

// Milliseconds and microseconds travel as doubles; a layout is in whole nanoseconds.
std::optional<Duration> nanoseconds(double count, double unit_ns) {
    const double ns = count * unit_ns;
    if (!(ns >= 0 && ns < 1e18)) return std::nullopt;
    return Duration(std::llround(ns));
}

// The names of the parts of the two scenes that are not the same in both.
std::string parts_that_differ(const proto::Hello& theirs, const proto::Hello& ours) {
    constexpr std::size_t most_named = 6;
    std::map<std::string, std::uint32_t> unmatched;
    for (const auto& part : ours.part()) unmatched.emplace(part.name(), part.fingerprint());
    for (const auto& part : theirs.part()) {
        const auto [at, is_new] = unmatched.emplace(part.name(), part.fingerprint());
        if (!is_new && at->second == part.fingerprint()) unmatched.erase(at);
    }
    std::string names;
    std::size_t named = 0;
    for (const auto& [name, fingerprint] : unmatched) {
        // A name that a peer has made up may be long.
        if (++named <= most_named) names += (named == 1 ? "" : ", ") + name.substr(0, 40);
    }
    if (named > most_named) names += " and " + digits(named - most_named) + " more";
    return names;
}

// The fields of the hello that say more than which scene it is: "packet_ms: 5 -> 10".
std::string values_that_differ(proto::Hello theirs, proto::Hello ours) {
    for (proto::Hello* const hello : {&theirs, &ours}) {
        hello->clear_nonce();
        hello->clear_scene_fingerprint();
        hello->clear_part();
    }
    google::protobuf::util::MessageDifferencer difference;
    std::string report;
    difference.ReportDifferencesToString(&report);
    if (difference.Compare(ours, theirs)) return "";
    std::replace(report.begin(), report.end(), '\n', ' ');
    if (report.ends_with(' ')) report.pop_back();
    // The text contains what the peer has sent, which may be long.
    constexpr std::size_t longest = 1000;
    return report.substr(0, longest);
}

constexpr double per_us = 1e3;
constexpr double per_ms = 1e6;

NeuronLaw law_of(const proto::NeuronDescription& neuron) {
    return {.tau_m_ms = neuron.tau_m_ms(),
            .tau_g_ms = neuron.tau_g_ms(),
            .v_r_mv = neuron.v_r_mv(),
            .v_th_mv = neuron.v_th_mv(),
            .e_k_mv = neuron.e_k_mv(),
            .delta_g = neuron.delta_g(),
            .refractory_ms = neuron.refractory_ms()};
}

}  // namespace

void describe(const PacketLayout& layout, proto::Hello& hello) {
    hello.set_version(wire_version);
    hello.set_addresses(layout.addresses);
    hello.set_tick_us(static_cast<double>(layout.tick.count()) / per_us);
    hello.set_packet_ms(static_cast<double>((layout.gathered_spans * layout.span).count()) / per_ms);
    if (layout.gathered_spans > 1) hello.set_prompt_ms(static_cast<double>(layout.span.count()) / per_ms);
    hello.set_heartbeat_ms(static_cast<double>(layout.heartbeat.count()) / per_ms);
    hello.set_packet_events(layout.max_events);
    static_assert(static_cast<int>(Encoding::predicted) == proto::PAYLOAD_PREDICTED);
    hello.set_encoding(static_cast<proto::PayloadEncoding>(layout.encoding));
    hello.set_timing_tolerance_us(static_cast<double>(layout.tolerance.count()) / per_us);
    hello.set_acknowledged(layout.acknowledged);
}

Result<PacketLayout> layout_of(const proto::Hello& hello) {
    const auto malformed = [](const std::string& text) {
        return Error{Error::Kind::malformed, "hello: " + text};
    };
    const auto tick = nanoseconds(hello.tick_us(), per_us);
    const auto packet = nanoseconds(hello.packet_ms(), per_ms);
    const auto span = hello.prompt_ms() == 0 ? packet : nanoseconds(hello.prompt_ms(), per_ms);
    const auto heartbeat = nanoseconds(hello.heartbeat_ms(), per_ms);
    if (!tick || !packet || !span || !heartbeat)
        return malformed("a time is negative, not finite or too long");
    if (*span <= 0ns || *packet % *span != 0ns || *packet / *span > 8000)
        return malformed("packet_ms must be a multiple of prompt_ms, at most 8000 times as long");
    if (!proto::PayloadEncoding_IsValid(hello.encoding())) return malformed("the encoding is unknown");
    PacketLayout layout;
    layout.addresses = hello.addresses();
    layout.tick = *tick;
    layout.span = *span;
    layout.gathered_spans = static_cast<std::uint32_t>(*packet / *span);
    layout.heartbeat = *heartbeat;
    layout.encoding = static_cast<Encoding>(hello.encoding());
    layout.max_events = hello.packet_events();
    if (layout.encoding == Encoding::predicted) {
        const auto tolerance = nanoseconds(hello.timing_tolerance_us(), per_us);
        if (!tolerance) return malformed("timing_tolerance_us is negative, not finite or too long");
        layout.tolerance = *tolerance;
        layout.acknowledged = hello.acknowledged();
        for (const proto::PatchAddresses& patch : hello.patch())
            layout.neurons.push_back({patch.count(), law_of(patch.neuron())});
    }
    try {
        layout.check();
    } catch (const ParameterError& error) {
        return malformed(error.what());
    }
    if (!(hello.freeze_ms() >= 2 * hello.heartbeat_ms()))
        return malformed("freeze_ms must be at least twice heartbeat_ms");
    if (!(hello.stale_ms() >= 0 && hello.stale_ms() < 1e9)) return malformed("stale_ms must be >= 0");
    if (!(hello.safe_ms() > hello.freeze_ms())) return malformed("safe_ms must be > freeze_ms");
    return layout;
}

std::optional<std::string> disagreement(const proto::Hello& theirs, const proto::Hello& ours) {
    const auto differ = [](const char* what, const std::string& their, const std::string& our) {
        return std::string(what) + " " + their + " is not ours, " + our;
    };
    if (theirs.version() != ours.version())
        return differ("wire version", digits(theirs.version()), digits(ours.version()));
    if (theirs.lockstep() != ours.lockstep())
        return std::string(theirs.lockstep() ? "they run in lockstep, we do not"
                                             : "we run in lockstep, they do not");
    const bool same_scene = theirs.scene_fingerprint() == ours.scene_fingerprint();
    if (!same_scene || theirs.patch_size() != ours.patch_size()) {
        const std::string names = same_scene ? "" : parts_that_differ(theirs, ours);
        std::string text = "the scenes differ" + (names.empty() ? "" : " in " + names);
        if (theirs.patch_size() != ours.patch_size())
            text +=
                "; " + differ("number of patches", digits(theirs.patch_size()), digits(ours.patch_size()));
        else if (const std::string values = values_that_differ(theirs, ours); !values.empty())
            text += "; from ours to theirs: " + values;
        return text;
    }
    // The two programs read the same scene differently.
    const std::string values = values_that_differ(theirs, ours);
    if (values.empty()) return std::nullopt;
    return "of the same scene, from ours to theirs: " + values;
}

}  // namespace afferent
