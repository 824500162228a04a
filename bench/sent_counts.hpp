// Send-on-delta and its kin: which elements of a scan are sent, and what the other end then knows of each.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/sample_coding.hpp"

namespace afferent {

// An element is sent when its count is a band or more from what the other end presumes of it.
struct ChangeRule {
    int band = 1;         // in counts; the least, where the band is a fraction of the value
    double fraction = 0;  // of what the other end presumes (Weber's law)
    // The other end presumes that the count goes on as a line; otherwise, that it stays.
    bool linear = false;
};

// What the other end presumes of each element, from scan to scan. Both ends have one: the sender calls send()
// for each scan, the receiver receive(), and both then presume the same. They begin at 0.
//
// Changes are sent in whole bands. With `linear` comes the slope of the last scans: a better one than the
// receiver could tell from values that are a band apart.
class SentCounts {
  public:
    // rule.band > 0, rule.fraction >= 0.
    SentCounts(std::uint32_t elements, const ChangeRule& rule);

    // Appends what is sent of a scan. `first` is added to the number of each element.
    void send(Counts scan, std::uint32_t first, std::vector<CountChange>& changes);
    // The same at the other end: the changes of one scan, numbered from `first` on.
    void receive(std::span<const CountChange> changes, std::uint32_t first);

    std::uint32_t elements() const noexcept { return static_cast<std::uint32_t>(states_.size()); }
    double presumed(std::uint32_t element) const noexcept { return states_[element].value; }
    bool moved(std::uint32_t element) const noexcept { return states_[element].moved != 0; }

    // Between which limits the last reading of an element was, before it was rounded.
    struct Range {
        double low;
        double high;
    };
    Range range(std::uint32_t element) const noexcept;

  private:
    static constexpr std::size_t fitted = 4;  // scans, from which the sender takes a slope

    struct State {
        double value = 0;
        std::int32_t slope = 0;  // by scan, in 1/32 of a band
        std::int32_t moved = 0;  // by so many bands in the last scan
        double step = 1;         // the band of that
        std::array<std::uint16_t, fitted> recent{};
    };

    void pass() noexcept;
    double band(double value) const noexcept;
    // Whether the values that are sent always lie on the same levels. Then a count has crossed the level that
    // is sent.
    bool levels_hold() const noexcept { return rule_.fraction == 0 && !rule_.linear; }
    std::int32_t slope_to_send(const State& state, double band) const noexcept;
    void take(State& state, std::int32_t amount, std::int32_t slope) noexcept;

    ChangeRule rule_;
    std::vector<State> states_;
};

}  // namespace afferent
