#include "afferent/io/files/event_set.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

namespace afferent {
namespace {

constexpr std::uint64_t format = 0x3174'6573'7665'6661;  // "afevset1"
constexpr std::uint64_t event_bytes = sizeof(std::int64_t) + sizeof(Address);

class Writer {
  public:
    explicit Writer(std::size_t size) { bytes_.reserve(size); }

    template <class T>
    void put(T value) {
        put(&value, sizeof value);
    }
    void put(const void* data, std::size_t size) {
        const auto* begin = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), begin, begin + size);
    }

    std::vector<std::byte> bytes() { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
};

// Past the end it reads zeros, and ended() is true.
class Cursor {
  public:
    explicit Cursor(std::span<const std::byte> bytes) : left_(bytes) {}

    template <class T>
    T take() {
        T value{};
        const auto bytes = take(sizeof value);
        if (!ended_) std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }
    std::span<const std::byte> take(std::size_t size) {
        if (size > left_.size()) {
            ended_ = true;
            left_ = {};
            return {};
        }
        const auto taken = left_.first(size);
        left_ = left_.subspan(size);
        return taken;
    }

    std::size_t left() const noexcept { return left_.size(); }
    bool ended() const noexcept { return ended_; }

  private:
    std::span<const std::byte> left_;
    bool ended_ = false;
};

Error damaged() { return {Error::Kind::malformed, "these are no events, or not all of them"}; }

}  // namespace

std::uint64_t EventSet::afferents() const noexcept {
    std::uint64_t sum = 0;
    for (const Patch& patch : patches) sum += patch.afferents;
    return sum;
}

Result<void> check(const EventSet& set) {
    const auto malformed = [](std::string text) { return Error{Error::Kind::malformed, std::move(text)}; };
    if (set.resolution < Duration(1)) return malformed("the resolution of the times is less than 1 ns");
    if (!std::is_sorted(set.events.begin(), set.events.end()))
        return malformed("the events are not sorted by time and address");
    if (!set.events.empty() && set.events.front().time < scene_start)
        return malformed("an event lies before the start");
    if (set.patches.empty()) return success();
    const std::uint64_t afferents = set.afferents();
    for (const Event& event : set.events)
        if (event.address >= afferents)
            return malformed("an event has address " + std::to_string(event.address) +
                             ", and the patches have " + std::to_string(afferents) + " afferents");
    return success();
}

std::vector<std::byte> to_bytes(const EventSet& set) {
    Writer out(64 + 64 * set.patches.size() + event_bytes * set.events.size());
    out.put(format);
    out.put(set.resolution.count());
    out.put(std::uint64_t{set.patches.size()});
    for (const EventSet::Patch& patch : set.patches) {
        out.put(std::uint64_t{patch.name.size()});
        out.put(patch.name.data(), patch.name.size());
        out.put(patch.afferents);
    }
    for (const Event& event : set.events) {
        out.put(std::int64_t{(event.time - scene_start).count()});
        out.put(event.address);
    }
    return out.bytes();
}

Result<EventSet> event_set(std::span<const std::byte> bytes) {
    Cursor in(bytes);
    EventSet set;
    if (in.take<std::uint64_t>() != format) return damaged();
    set.resolution = Duration(in.take<std::int64_t>());
    for (auto patches = in.take<std::uint64_t>(); patches > 0 && !in.ended(); --patches) {
        const auto name = in.take(in.take<std::uint64_t>());
        set.patches.push_back(
            {{reinterpret_cast<const char*>(name.data()), name.size()}, in.take<std::uint32_t>()});
    }
    if (in.ended() || in.left() % event_bytes != 0) return damaged();
    set.events.resize(in.left() / event_bytes);
    for (Event& event : set.events) {
        event.time = scene_start + Duration(in.take<std::int64_t>());
        event.address = in.take<Address>();
    }
    AFFERENT_TRY(check(set));
    return set;
}

}  // namespace afferent
