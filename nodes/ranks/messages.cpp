#include "afferent/nodes/ranks/messages.hpp"

#include <cassert>
#include <cstring>
#include <limits>
#include <type_traits>

namespace afferent::ranks {
namespace {

template <class T>
void put(Bytes& bytes, const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* begin = reinterpret_cast<const std::byte*>(values);
    bytes.insert(bytes.end(), begin, begin + count * sizeof(T));
}

// Reads what put() wrote, from `at` on.
template <class T>
void take(const Bytes& bytes, std::size_t& at, T* values, std::size_t count) {
    assert(at + count * sizeof(T) <= bytes.size());
    if (count > 0) std::memcpy(values, bytes.data() + at, count * sizeof(T));
    at += count * sizeof(T);
}

std::int64_t nanoseconds(TimePoint time) { return (time - scene_start).count(); }

struct Window {
    std::int64_t from_ns;
    std::int64_t until_ns;
};

struct Sent {
    std::uint32_t after_ns;
    Address address;
};

struct ScanHead {
    std::int64_t time_ns;
    Address first;
    std::uint32_t count;
};

}  // namespace

void put_events(Bytes& bytes, TimePoint from, TimePoint until, std::span<const Event> events) {
    assert(until - from <= Duration(std::numeric_limits<std::uint32_t>::max()));
    const Window window{nanoseconds(from), nanoseconds(until)};
    put(bytes, &window, 1);
    const std::size_t begin = bytes.size();
    bytes.resize(begin + events.size() * sizeof(Sent));
    std::byte* at = bytes.data() + begin;
    for (const Event& event : events) {
        const Sent sent{static_cast<std::uint32_t>((event.time - from).count()), event.address};
        std::memcpy(at, &sent, sizeof sent);
        at += sizeof sent;
    }
}

TimePoint take_events(const Bytes& bytes, std::vector<Event>& events) {
    std::size_t at = 0;
    Window window{};
    take(bytes, at, &window, 1);
    const TimePoint from = scene_start + Duration(window.from_ns);
    for (; at < bytes.size();) {
        Sent sent{};
        take(bytes, at, &sent, 1);
        events.push_back({from + Duration(sent.after_ns), sent.address});
    }
    return scene_start + Duration(window.until_ns);
}

void put_scan(Bytes& bytes, const Scan& scan) {
    const ScanHead head{nanoseconds(scan.time), scan.first, static_cast<std::uint32_t>(scan.forces_n.size())};
    put(bytes, &head, 1);
    put(bytes, scan.forces_n.data(), scan.forces_n.size());
}

void put_end(Bytes& bytes, TimePoint until) {
    const std::int64_t until_ns = nanoseconds(until);
    put(bytes, &until_ns, 1);
}

TimePoint take_scans(const Bytes& bytes, std::vector<double>& forces_n,
                     const std::function<void(const Scan&)>& use) {
    std::size_t at = 0;
    while (at + sizeof(ScanHead) <= bytes.size()) {
        ScanHead head{};
        take(bytes, at, &head, 1);
        forces_n.resize(head.count);
        take(bytes, at, forces_n.data(), head.count);
        use({scene_start + Duration(head.time_ns), head.first, forces_n});
    }
    std::int64_t until_ns = 0;
    take(bytes, at, &until_ns, 1);
    return scene_start + Duration(until_ns);
}

void put_report(Bytes& bytes, const Report& report) { put(bytes, &report, 1); }

Report take_report(const Bytes& bytes) {
    std::size_t at = 0;
    Report report;
    take(bytes, at, &report, 1);
    return report;
}

}  // namespace afferent::ranks
