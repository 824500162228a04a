#include "afferent/io/files/event_set.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace afferent {
namespace {

constexpr std::uint64_t format = 0x3274'6573'7665'6661;  // "afevset2"
constexpr std::uint64_t event_bytes = sizeof(std::int64_t) + sizeof(Address);
constexpr std::uint64_t afferent_bytes = 1 + 2 * sizeof(double) + sizeof(Address) + sizeof(std::uint32_t);

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

    void put_text(const std::string& text) {
        put(std::uint64_t{text.size()});
        put(text.data(), text.size());
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

    std::string take_text() {
        const auto text = take(take<std::uint64_t>());
        return {reinterpret_cast<const char*>(text.data()), text.size()};
    }

    std::size_t left() const noexcept { return left_.size(); }
    bool ended() const noexcept { return ended_; }

  private:
    std::span<const std::byte> left_;
    bool ended_ = false;
};

Error damaged() { return {Error::Kind::malformed, "these are no events, or not all of them"}; }

}  // namespace

Result<void> check(const EventSet& set) {
    const auto malformed = [](std::string text) { return Error{Error::Kind::malformed, std::move(text)}; };
    if (set.resolution < Duration(1)) return malformed("the resolution of the times is less than 1 ns");
    if (!std::is_sorted(set.events.begin(), set.events.end()))
        return malformed("the events are not sorted by time and address");
    if (!set.events.empty() && set.events.front().time < scene_start)
        return malformed("an event lies before the start");
    const Population& population = set.population;
    const std::uint64_t afferents = population.size();
    if (!population.afferents.empty() && population.afferents.size() != afferents)
        return malformed("the patches have " + std::to_string(afferents) + " afferents, and " +
                         std::to_string(population.afferents.size()) + " are told of");
    for (const Population::Afferent& each : population.afferents)
        if (each.place && !(std::isfinite(each.place->x_mm) && std::isfinite(each.place->y_mm)))
            return malformed("an afferent has a place that is none");
    if (population.patches.empty()) return success();
    for (const Event& event : set.events)
        if (event.address >= afferents)
            return malformed("an event has address " + std::to_string(event.address) +
                             ", and the patches have " + std::to_string(afferents) + " afferents");
    return success();
}

std::vector<std::byte> to_bytes(const EventSet& set) {
    const Population& population = set.population;
    Writer out(64 + 64 * population.patches.size() + afferent_bytes * population.afferents.size() +
               event_bytes * set.events.size());
    out.put(format);
    out.put(set.resolution.count());
    out.put(std::uint64_t{population.patches.size()});
    for (const Population::Patch& patch : population.patches) {
        out.put_text(patch.name);
        out.put_text(patch.kind);
        out.put(patch.afferents);
    }
    out.put(std::uint64_t{population.afferents.size()});
    for (const Population::Afferent& each : population.afferents) {
        out.put(std::uint8_t{each.place.has_value()});
        out.put(each.place.value_or(Position()).x_mm);
        out.put(each.place.value_or(Position()).y_mm);
        out.put(each.element);
        out.put(each.elements);
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
        Population::Patch& patch = set.population.patches.emplace_back();
        patch.name = in.take_text();
        patch.kind = in.take_text();
        patch.afferents = in.take<std::uint32_t>();
    }
    for (auto afferents = in.take<std::uint64_t>(); afferents > 0 && !in.ended(); --afferents) {
        Population::Afferent& each = set.population.afferents.emplace_back();
        const bool has_place = in.take<std::uint8_t>() != 0;
        const Position place{in.take<double>(), in.take<double>()};
        if (has_place) each.place = place;
        each.element = in.take<Address>();
        each.elements = in.take<std::uint32_t>();
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
