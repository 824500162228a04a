// The link between coprocessor and hand: transport, timing, keys, and emulated channel. Included with
// scene.hpp by whoever builds a scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "afferent/runtime/time.hpp"
#include "afferent/scene/fields.hpp"

namespace afferent {

namespace scene {

struct InProcess {
    static constexpr const char* alternative = "in_process";
    bool operator==(const InProcess&) const = default;
    static void fields(auto&, auto&&) {}
};

struct UnixSocket {
    static constexpr const char* alternative = "unix_socket";
    std::string path = "afferent.sock";
    bool operator==(const UnixSocket&) const = default;
    static void fields(auto& self, auto&& f) { f("path", self.path); }
};

struct Tcp {
    static constexpr const char* alternative = "tcp";
    std::string host = "127.0.0.1";
    std::uint32_t port = 7450;
    bool operator==(const Tcp&) const = default;
    static void fields(auto& self, auto&& f) {
        f("host", self.host);
        f(within("port", 0, 65535), self.port);
    }
};

struct Udp {
    static constexpr const char* alternative = "udp";
    std::string host = "127.0.0.1";
    std::uint32_t port = 7450;
    bool operator==(const Udp&) const = default;
    static void fields(auto& self, auto&& f) {
        f("host", self.host);
        f(within("port", 0, 65535), self.port);
    }
};

struct Serial {
    static constexpr const char* alternative = "serial";
    std::string device = {};
    std::uint32_t baud = 921'600;
    bool operator==(const Serial&) const = default;
    static void fields(auto& self, auto&& f) {
        f("device", self.device);
        f(within("baud", 1200, 4e6), self.baud);
    }
};

struct File {
    static constexpr const char* alternative = "file";
    std::string path = {};
    bool operator==(const File&) const = default;
    static void fields(auto& self, auto&& f) { f("path", self.path); }
};

using Transport = std::variant<InProcess, UnixSocket, Tcp, Udp, Serial, File>;

enum class Encoding { rice, fixed_width, predicted };
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
    static void fields(auto& self, auto&& f) {
        f(within("bandwidth_bps", 0, 1e15), self.bandwidth_bps);
        f(within("latency_ms", 0, 10000), self.latency_ms);
        f(within("jitter_ms", 0, 10000), self.jitter_ms);
        f(within("loss", 0, 1), self.loss);
        f(within("reorder", 0, 1), self.reorder);
        f(within("duplicate", 0, 1), self.duplicate);
        f(within("corrupt", 0, 1), self.corrupt);
        f(within("fifo_events", 0, 1e9), self.fifo_events);
        f("drop_policy", self.drop_policy);
    }
};

struct Bus {
    std::uint32_t cycle_ns = 100;
    std::uint32_t rows = 1;
    std::uint32_t row_events = 16;
    bool operator==(const Bus&) const = default;
    static void fields(auto& self, auto&& f) {
        f(within("cycle_ns", 1, 1e9), self.cycle_ns);
        f(within("rows", 1, 1e7), self.rows);
        f(within("row_events", 1, 1e7), self.row_events);
    }
};

struct Link {
    Transport transport = {};
    std::optional<std::string> keys = {};
    double tick_us = 100;
    double packet_ms = 5;
    std::optional<double> prompt_ms = {};
    std::uint32_t packet_events = 4096;
    double delivery_ms = 2;
    double stale_ms = 50;
    double heartbeat_ms = 25;
    double freeze_ms = 60;
    double safe_ms = 150;
    Encoding encoding = Encoding::rice;
    double timing_tolerance_us = 0;
    double connect_s = 10;
    std::optional<Channel> channel = {};
    std::optional<Bus> bus = {};
    bool operator==(const Link&) const = default;
    static void fields(auto& self, auto&& f) {
        f.arms(self.transport);
        f("keys", self.keys);
        f(within("tick_us", 1, 1000), self.tick_us);
        f(within("packet_ms", 0.001, 1000), self.packet_ms);
        f(within("prompt_ms", 0.001, 1000), self.prompt_ms);
        f(within("packet_events", 1, 50000), self.packet_events);
        f(within("delivery_ms", 0, 10000), self.delivery_ms);
        f(within("stale_ms", 0, 1e6), self.stale_ms);
        f(within("heartbeat_ms", 0.001, 10000), self.heartbeat_ms);
        f(within("freeze_ms", 0.002, 1e6), self.freeze_ms);
        f(within("safe_ms", 0.002, 1e6), self.safe_ms);
        f("encoding", self.encoding);
        f(within("timing_tolerance_us", 0, 1e6), self.timing_tolerance_us);
        f(within("connect_s", 0, 1e9), self.connect_s);
        f("channel", self.channel);
        f("bus", self.bus);
    }
};

}  // namespace scene

struct Plan;
struct Scene;
class PlanItems;
class SceneFaults;

// Properties of a transport.
struct TransportTraits {
    bool packets = true;     // false: events are passed without packets
    bool datagrams = false;  // frames may be lost, repeated or reordered
    bool keys = false;       // leaves the machine, and may have keys
    bool live = true;        // false: the other end reads later
    double cobs_bytes = 0;   // added to each packet by a serial line
    double cobs_factor = 1;  // bytes on a serial line per byte
    std::string text;        // "TCP 127.0.0.1:7450"
};
TransportTraits traits_of(const scene::Transport& transport);

// The recording, if the link is one.
std::optional<std::filesystem::path> link_file(const Scene& scene);

struct LinkTiming {
    Duration tick;
    Duration packet;
    Duration span;  // what packets are whole multiples of: prompt_ms, or packet_ms without it
    Duration delivery;
    Duration overtaking;  // how long a packet waits for those that it overtook
    Duration stale;       // packets of this age and above are not used
    Duration heartbeat;
    Duration freeze;
    Duration safe;
    Duration distrust = 10s;  // for so long after a packet that was late or lost nothing is presumed
};
LinkTiming link_timing(const scene::Link& link);

void check(const scene::Link& link, SceneFaults& faults);
void add_link_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
