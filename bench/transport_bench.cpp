#include "bench/transport_bench.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <random>
#include <stdexcept>
#include <utility>

#include "afferent/io/links/transports.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "bench/link_activity.hpp"
#include "bench/serial_line.hpp"
#include "bench/short_lived_keys.hpp"

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double rate_hz = 20;
constexpr int spans = 64;
constexpr std::uint32_t baud = 921'600;
// After this time a packet counts as lost, which only a datagram can be.
constexpr auto patience = std::chrono::milliseconds(500);

// A serial line is given a hundredth of the addresses.
std::uint32_t addresses_of(const std::string& transport) { return transport == "serial" ? 1000 : 100'000; }
int rounds_of(const std::string& transport) { return transport == "serial" ? 3 : 30; }

bool over_datagrams(const std::string& transport) {
    return transport == "udp" || transport == "udp_sealed" || transport == "serial";
}

std::filesystem::path temporary(const std::string& name) {
    return std::filesystem::temp_directory_path() / (name + std::to_string(std::random_device()()));
}

// Frames are passed to a reader in the same memory.
class MemoryLink final : public Link {
  public:
    void start(LinkCallbacks callbacks) override { callbacks_ = std::move(callbacks); }
    bool send(const proto::Envelope& message) override {
        auto frame = writer_.stream_frame(message);
        while (!frame.empty()) {
            const auto space = reader_.space();
            const std::size_t count = std::min(space.size(), frame.size());
            std::copy_n(frame.begin(), count, space.begin());
            reader_.filled(count);
            frame = frame.subspan(count);
            while (reader_.next(received_).value()) callbacks_.message(received_);
        }
        return true;
    }
    void close() override {}
    std::size_t queued_bytes() const override { return 0; }
    bool ordered() const override { return true; }
    const LinkCounts& counts() const override { return counts_; }

  private:
    LinkCallbacks callbacks_;
    FrameWriter writer_;
    FrameReader reader_;
    proto::Envelope received_;
    LinkCounts counts_;
};

struct Ends {
    std::unique_ptr<SerialLine> line;
    std::unique_ptr<ShortLivedKeys> keys;
    std::unique_ptr<Listener> listener;
    std::unique_ptr<Link> sender;
    std::unique_ptr<Link> receiver;  // in memory: the sender itself
};

Ends open(boost::asio::io_context& io, const std::string& transport) {
    Ends ends;
    if (transport == "in_process") {
        ends.sender = std::make_unique<MemoryLink>();
        return ends;
    }
    ends.keys = std::make_unique<ShortLivedKeys>();
    if (transport == "serial") ends.line = std::make_unique<SerialLine>(io);
    const TlsCredentials hand = ends.keys->credentials(LinkEnd::hand);
    const TlsCredentials coprocessor = ends.keys->credentials(LinkEnd::coprocessor);
    const LinkAddress address = [&]() -> LinkAddress {
        if (transport == "tcp") return TcpAddress{"127.0.0.1", 0};
        if (transport == "tls") return TlsAddress{"127.0.0.1", 0, hand};
        if (transport == "udp") return UdpAddress{"127.0.0.1", 0, std::nullopt};
        if (transport == "udp_sealed") return UdpAddress{"127.0.0.1", 0, hand};
        if (transport == "serial") return SerialAddress{ends.line->first(), baud, hand};
        return UnixAddress{temporary("afferent-bench-")};
    }();
    // Large enough that nothing is dropped, and patient: this measures latency, not loss.
    const LinkOptions options{.kernel_buffer_bytes = std::size_t{1} << 20,
                              .queue_bytes = std::size_t{1} << 26,
                              .silence_limit = std::chrono::minutes(1)};
    auto listener = open_listener(io, address, options);
    if (!listener) throw std::runtime_error(listener.error().text);
    ends.listener = std::move(listener).value();
    ends.listener->start([&](std::unique_ptr<Link> link) { ends.receiver = std::move(link); });
    LinkAddress other_end = ends.listener->address();
    if (ends.line) other_end = SerialAddress{ends.line->second(), baud, coprocessor};
    if (auto* const tls = std::get_if<TlsAddress>(&other_end)) tls->credentials = coprocessor;
    if (auto* const udp = std::get_if<UdpAddress>(&other_end); udp != nullptr && udp->credentials)
        udp->credentials = coprocessor;
    const auto connector = make_connector(io, other_end, {}, options);
    connector->start([&](Result<std::unique_ptr<Link>> link) {
        if (!link) throw std::runtime_error(link.error().text);
        ends.sender = std::move(link).value();
        ends.sender->start({[](const auto&) {}, [](const Error&) {}, [](const Error&) {}});
        // A listener hands over a link once its peer has sent a hello.
        proto::Envelope hello;
        hello.mutable_hello();
        ends.sender->send(hello);
    });
    while (!ends.receiver || !ends.sender) io.run_one();
    return ends;
}

TransportResult measure(const std::string& transport, Duration packet) {
    const std::uint32_t addresses = addresses_of(transport);
    // A stream carries each packet whole; datagrams carry the longest in parts.
    const PacketLayout layout{.addresses = addresses,
                              .span = packet,
                              .heartbeat = std::max<Duration>(25ms, packet),
                              .max_events = over_datagrams(transport) ? 20'000U : 50'000U};
    if (over_datagrams(transport) && most_packet_bytes(layout) > max_datagram_frame_bytes)
        throw std::runtime_error("a packet of this benchmark does not fit into a datagram");
    const LinkActivity activity = poisson_activity(addresses, rate_hz, spans * packet, 1);
    boost::asio::io_context io;
    Ends ends = open(io, transport);
    Packetizer packetizer(layout);
    PacketReceiver receiver(layout);
    std::uint64_t received = 0;
    Link& receiving = ends.receiver ? *ends.receiver : *ends.sender;
    receiving.start({[&](const proto::Envelope& message) {
                         if (is_packet(message)) received += receiver.receive(message).value().events.size();
                     },
                     [](const Error& error) { throw std::runtime_error(error.text); },
                     [](const Error& error) { throw std::runtime_error(error.text); }});

    std::vector<double> latencies_us;
    std::vector<Event> events;
    std::uint64_t sent = 0;
    std::uint64_t counted = 0;
    double busy_s = 0;
    for (int round = 0; round < rounds_of(transport); ++round) {
        auto first = activity.events.begin();
        const Duration offset = round * activity.duration;
        for (int span = 1; span <= spans; ++span) {
            const auto last = std::partition_point(first, activity.events.end(), [&](const Event& e) {
                return e.time < scene_start + span * packet;
            });
            events.assign(first, last);
            for (Event& event : events) event.time += offset;
            first = last;
            const auto begin = Clock::now();
            packetizer.push(events);
            packetizer.close(scene_start + offset + span * packet,
                             [&](const proto::Envelope& message) { ends.sender->send(message); });
            sent += events.size();
            while (received < sent && Clock::now() < begin + patience) io.run_one_until(begin + patience);
            if (std::exchange(sent, received) > received) continue;  // lost: it has no latency
            const Interval taken = Clock::now() - begin;
            counted += events.size();
            latencies_us.push_back(taken.count() / 1e3);
            busy_s += taken.count() / 1e9;
        }
    }
    std::sort(latencies_us.begin(), latencies_us.end());
    const auto share = [&](double s) {
        return latencies_us[static_cast<std::size_t>(s * static_cast<double>(latencies_us.size() - 1))];
    };
    return {transport, packet, static_cast<double>(counted) / busy_s, share(0.5), share(0.99)};
}

}  // namespace

std::vector<TransportResult> measure_transports(const std::vector<Duration>& packets) {
    std::vector<TransportResult> results;
    for (const char* transport : {"in_process", "unix", "tcp", "tls", "udp", "udp_sealed", "serial"})
        for (const Duration packet : packets) results.push_back(measure(transport, packet));
    return results;
}

}  // namespace afferent
