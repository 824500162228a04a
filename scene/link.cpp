#include "afferent/scene/link.hpp"

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene_faults.hpp"

namespace afferent {
namespace {

std::string at(const std::string& host, std::uint32_t port) { return host + ":" + std::to_string(port); }

void check_port(std::uint32_t port, const char* field, bool has_channel) {
    if (has_channel)
        require(port < 65'535, field, "below 65535 where there is a channel, which takes the next one", port);
}

void check_unix_socket(const scene::UnixSocket& socket, bool has_channel) {
    // The longest path that a socket's address holds.
    if (socket.path.empty() || socket.path.size() > 107)
        throw ParameterError("unix_socket.path", "1 to 107 characters", "\"" + socket.path + "\"");
    if (has_channel)
        require(socket.path.size() <= 99, "unix_socket.path",
                "at most 99 characters where there is a channel", static_cast<double>(socket.path.size()));
}

void check_serial(const scene::Serial& serial, bool has_keys) {
    require_path(serial.device, "serial.device", "the path of a tty");
    if (!has_keys)
        throw ParameterError("serial", "on a link with keys, which afferent keys makes", "without");
}

void check_transport(const scene::Link& link) {
    const bool has_channel = link.channel.has_value();
    std::visit(
        Overloaded{
            [](const scene::InProcess&) {},
            [&](const scene::UnixSocket& socket) { check_unix_socket(socket, has_channel); },
            [&](const scene::Tcp& tcp) { check_port(tcp.port, "tcp.port", has_channel); },
            [&](const scene::Udp& udp) { check_port(udp.port, "udp.port", has_channel); },
            [&](const scene::Serial& serial) { check_serial(serial, link.keys && !link.keys->empty()); },
            [](const scene::File& file) { require_path(file.path, "file.path", "the path of a recording"); }},
        link.transport);
    if (!link.keys) return;
    require_path(*link.keys, "keys", "the path of a folder");
    if (!traits_of(link.transport).keys)
        throw ParameterError("keys", "on a link that can leave the machine: tcp, udp or serial",
                             "on another");
}

void check_encoding(const scene::Link& link) {
    if (link.encoding != scene::Encoding::predicted && link.timing_tolerance_us > 0)
        throw ParameterError("timing_tolerance_us", "0 unless encoding is PREDICTED",
                             link.timing_tolerance_us);
}

void check_timing(const scene::Link& link) {
    const LinkTiming timing = link_timing(link);
    if (timing.packet % timing.tick != 0ns)
        throw ParameterError("packet_ms", "a multiple of tick_us", link.packet_ms);
    if (timing.span % timing.tick != 0ns)
        throw ParameterError("prompt_ms", "a multiple of tick_us", *link.prompt_ms);
    if (timing.packet % timing.span != 0ns)
        throw ParameterError("prompt_ms", "a whole part of packet_ms", *link.prompt_ms);
    require(link.heartbeat_ms >= link.packet_ms, "heartbeat_ms", ">= packet_ms", link.heartbeat_ms);
    require(link.freeze_ms >= 2 * link.heartbeat_ms, "freeze_ms", "at least twice heartbeat_ms",
            link.freeze_ms);
    require(link.safe_ms > link.freeze_ms, "safe_ms", "> freeze_ms", link.safe_ms);
}

void add_encoding_item(const Plan& plan, PlanItems& items) {
    const scene::Link& link = plan.scene.link;
    const bool predicted = link.encoding == scene::Encoding::predicted;
    items.add(
        "prediction of spikes", predicted,
        !predicted
            ? "link.encoding is not PREDICTED: every event is sent"
            : "link.encoding: what comes within " +
                  decimal(Milliseconds(plan.packets->tolerance).count() * 1e3) +
                  " us of when both ends foresee it is not sent; what does not leaves with its packet" +
                  (plan.packets->acknowledged ? "; packets refer to what the hand has acknowledged" : ""));
}

void add_presumption_item(const Plan& plan, PlanItems& items) {
    const std::string counts = plan.packets->tolerance > 0ns ? "as foreseen" : "as silent";
    items.add("presumption", plan.controller->presumes,
              plan.controller->presumes
                  ? "a span without a packet counts " + counts +
                        " link.delivery_ms after its end, unless one was late or lost in the last " +
                        decimal(seconds(plan.timing.distrust)) + " s"
                  : "what is not sent is foreseen from what the hand has acknowledged, and comes with the "
                    "next packet");
}

void add_watch_items(const Plan& plan, PlanItems& items) {
    const scene::Link& link = plan.scene.link;
    items.add("refusal of stale packets", true,
              "older than " + decimal(Milliseconds(plan.timing.stale).count()) + " ms when they come");
    items.add("watch for silence", true,
              "no closing after " + decimal(link.freeze_ms) + " ms, safe state after " +
                  decimal(link.safe_ms) + " ms");
    const bool by_user = plan.scene.hand.rearm == Rearm::by_user;
    items.add("acknowledgement by the user", by_user,
              by_user ? "hand.rearm is BY_USER: a safe hand operates again when its user says so"
                      : "hand.rearm is NEW_SESSION: a new session re-arms a safe hand");
}

}  // namespace

TransportTraits traits_of(const scene::Transport& transport) {
    return std::visit(
        Overloaded{
            [](const scene::InProcess&) { return TransportTraits{.packets = false, .text = "in process"}; },
            [](const scene::UnixSocket& socket) {
                return TransportTraits{.text = "Unix socket " + socket.path};
            },
            [](const scene::Tcp& tcp) {
                return TransportTraits{.keys = true, .text = "TCP " + at(tcp.host, tcp.port)};
            },
            [](const scene::Udp& udp) {
                return TransportTraits{
                    .datagrams = true, .keys = true, .text = "UDP " + at(udp.host, udp.port)};
            },
            // COBS adds delimiters, and a byte for each 254.
            [](const scene::Serial& serial) {
                return TransportTraits{
                    .datagrams = true,
                    .keys = true,
                    .cobs_bytes = 4,
                    .cobs_factor = 1.0 + 1.0 / 254,
                    .text = "serial line " + serial.device + ", " + std::to_string(serial.baud) + " baud"};
            },
            [](const scene::File& file) {
                return TransportTraits{.live = false, .text = "file " + file.path};
            }},
        transport);
}

std::optional<std::filesystem::path> link_file(const Scene& scene) {
    const auto* const file = std::get_if<scene::File>(&scene.link.transport);
    if (!file) return std::nullopt;
    return scene.resolve(file->path);
}

LinkTiming link_timing(const scene::Link& link) {
    return {.tick = rounded(std::chrono::duration<double, std::micro>(link.tick_us)),
            .packet = from_milliseconds(link.packet_ms),
            .span = from_milliseconds(link.prompt_ms.value_or(link.packet_ms)),
            .delivery = from_milliseconds(link.delivery_ms),
            .overtaking = from_milliseconds(std::min(link.delivery_ms, link.heartbeat_ms)),
            .stale = from_milliseconds(link.delivery_ms + link.stale_ms),
            .heartbeat = from_milliseconds(link.heartbeat_ms),
            .freeze = from_milliseconds(link.freeze_ms),
            .safe = from_milliseconds(link.safe_ms)};
}

void check(const scene::Link& link, SceneFaults& faults) {
    faults.check("link", "", [&] {
        check_timing(link);
        check_transport(link);
        check_encoding(link);
    });
    if (link.channel)
        faults.check("link", "", [&] {
            if (!traits_of(link.transport).packets)
                throw ParameterError("channel", "on a link with packets, tcp, unix_socket, udp or serial",
                                     "in process");
        });
}

void add_link_items(const Plan& plan, PlanItems& items) {
    const scene::Link& link = plan.scene.link;
    const TransportTraits transport = traits_of(link.transport);
    items.add("packets and codec", plan.packets.has_value(),
              plan.packets ? "the link leaves the process: " + transport.text
                           : "the link is in process: events are handed over");
    if (plan.packets)
        items.add("prompt packets", plan.timing.span < plan.timing.packet,
                  plan.timing.span < plan.timing.packet
                      ? "link.prompt_ms: a touch begins with packets of " + decimal(*link.prompt_ms) + " ms"
                      : "link.prompt_ms is not given: every packet closes after packet_ms");
    if (plan.packets) add_encoding_item(plan, items);
    if (plan.packets && plan.controller) add_presumption_item(plan, items);
    items.add("keys", link.keys.has_value(),
              !link.keys ? "link.keys is not given: the link does not leave the machine"
              : !transport.datagrams
                  ? "link.keys: TLS 1.3, both certificates pinned"
                  : "link.keys: DTLS, both certificates pinned; each datagram sealed with ChaCha20-Poly1305");
    items.add("channel", link.channel.has_value(),
              link.channel ? "link.channel is between the two ends: afferent channel, or a run's own"
                           : "link.channel is not given: nothing is lost or delayed on purpose");
    if (plan.packets && transport.live) add_watch_items(plan, items);
}

}  // namespace afferent
