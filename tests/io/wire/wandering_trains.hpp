// Trains of spikes that are the same on every machine, and the checksum of what the predictor makes of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "afferent/io/wire/spike_predictor.hpp"

namespace afferent {

inline PacketLayout predicted(Address addresses, Duration tolerance = 0us) {
    return {.addresses = addresses,
            .encoding = Encoding::predicted,
            .tolerance = tolerance,
            .neurons = {{addresses, {}}}};
}

// Ticks of spikes in integers alone, so that they are the same everywhere: intervals that wander, now and
// then a pause and a burst.
class WanderingTrain {
  public:
    explicit WanderingTrain(std::uint64_t seed) : state_(seed) {}

    std::uint64_t below(std::uint64_t bound) {
        state_ = state_ * 6'364'136'223'846'793'005 + 1'442'695'040'888'963'407;
        return (state_ >> 33) % bound;
    }

    std::uint64_t next() {
        interval_ += below(9);
        interval_ -= std::min<std::uint64_t>(interval_ - 20, below(9));
        tick_ += below(100) == 0 ? 3'000 : below(60) == 0 ? below(3) : interval_;
        return tick_;
    }

  private:
    std::uint64_t state_;
    std::uint64_t interval_ = 150;
    std::uint64_t tick_ = 0;
};

using Spans = std::vector<std::vector<Code>>;

inline Spans wandering(const PacketLayout& layout, std::size_t spans, std::uint64_t seed) {
    const auto ticks = static_cast<std::uint64_t>(layout.span / layout.tick);
    Spans found(spans);
    for (Address address = 0; address < layout.addresses; ++address) {
        WanderingTrain train(seed * 1000 + address);
        for (std::uint64_t tick = train.next(); tick < ticks * spans; tick = train.next())
            found[tick / ticks].push_back(static_cast<Code>(tick % ticks * layout.addresses + address));
    }
    for (auto& codes : found) std::sort(codes.begin(), codes.end());
    return found;
}

// Compilers, their options and processors must agree on this number: change it only with the wire's version.
inline constexpr std::uint64_t expected_checksum = 2'375'867'684'713'938'603U;

inline std::uint64_t payload_checksum() {
    PacketLayout layout = predicted(20);
    layout.neurons = {{13, {}}, {7, {}}};
    SpikePredictor predictor(layout);
    std::uint64_t checksum = 0;
    std::string payload;
    for (const std::vector<Code>& codes : wandering(layout, 2'000, 3)) {
        predictor.encode(codes, payload, {});
        for (const char byte : payload)
            checksum = (checksum ^ static_cast<unsigned char>(byte)) * 0x100'0000'01b3;
    }
    return checksum;
}

}  // namespace afferent
