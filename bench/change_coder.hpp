// Changes of counts into bytes: range-coded like predicted spikes, with chances that both ends learn from
// them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/sample_coding.hpp"

namespace afferent {

// Each end has one, for the same packets in the same order. Of each element of each scan a bit says whether
// it has changed; how likely that is follows from how long ago it did so, how long it took before, and
// whether its neighbours have. The sign follows from those of its last change and of its neighbour's; amounts
// and slopes are Elias's gamma codes whose bits are learnt, too.
class ChangeCoder {
  public:
    explicit ChangeCoder(std::uint32_t elements, bool slopes = false);

    // Changes of so many scans in a row, each numbered on from those of the one before, in increasing order.
    // Without a change there is no payload, and nothing need be sent.
    void encode(std::span<const CountChange> changes, std::uint32_t scans, std::string& payload);
    // False where no encoder has written that; afterwards this end knows no more.
    bool decode(std::string_view payload, std::uint32_t scans, std::vector<CountChange>& changes);

    // A bit whose chance is the mean of those that came, the last hundred or so counting most.
    struct Bit {
        std::uint32_t one = 1 << 23;  // in 2^-24
        std::uint32_t seen = 0;
    };

  private:
    static constexpr std::uint32_t most_exponent = 16;
    static constexpr std::uint32_t learnt = 4;  // bits of a number under its highest
    struct Number {
        std::array<Bit, most_exponent> exponent;
        std::array<std::array<Bit, 1 << learnt>, most_exponent> rest;
    };

    struct Element {
        std::uint32_t last = 0;      // scan of its last change
        std::uint32_t interval = 0;  // from the one before it; 0: there was none
        std::int8_t sign = 0;
        std::uint8_t size = 0;  // of its last amount
    };

    class Write;
    class Read;

    template <class Ends>
    bool walk(Ends& ends, std::uint32_t scans);
    template <class Ends>
    bool number(Ends& ends, Number& model, std::uint32_t& value);
    std::size_t context(const Element& element, std::uint32_t neighbours) const noexcept;

    static constexpr std::size_t ages = 8;

    bool slopes_;
    std::vector<Element> elements_;
    std::uint32_t scan_ = 1;  // how many were before, and one: 0 is long ago
    std::array<Bit, ages * 4 * 4> changed_;
    std::array<Bit, 9> negative_;
    std::array<Number, 6> amount_;
    // One model for changes upwards, one for changes downwards.
    std::array<Bit, 2> level_;
    std::array<Bit, 2> falling_;
    Number slope_;
};

}  // namespace afferent
