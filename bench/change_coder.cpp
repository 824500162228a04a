#include "bench/change_coder.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "afferent/io/wire/range_coder.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t certain = 1 << 16;
constexpr std::uint32_t finer = 8;  // bits, of what is learnt
constexpr std::uint32_t remembered = 120;

std::uint32_t chance(const ChangeCoder::Bit& bit) {
    constexpr std::uint32_t least = 4;
    return std::clamp(bit.one >> finer, least, certain - least);
}

// By half a bit more than was seen: the estimate of Krichevsky and Trofimov, until the memory is full.
void learn(ChangeCoder::Bit& bit, bool one) {
    if (bit.seen < remembered) ++bit.seen;
    const std::int64_t aim = one ? std::int64_t{certain} << finer : 0;
    bit.one = static_cast<std::uint32_t>(bit.one + (aim - bit.one) * 2 / (2 * std::int64_t{bit.seen} + 1));
}

}  // namespace

// Both ends are given what is written, and answer with what was: the reader knows nothing but its payload.
class ChangeCoder::Write {
  public:
    Write(std::span<const CountChange> changes, std::string& payload)
        : next_(changes.begin()), end_(changes.end()), range_(payload) {}

    CountChange next() const { return next_ == end_ ? CountChange{none, 0} : *next_; }
    void took(const CountChange&) { ++next_; }
    bool bit(Bit& model, bool one) {
        const std::uint32_t part = chance(model);
        range_.put(one ? 0 : part, one ? part : certain - part, certain);
        learn(model, one);
        return one;
    }
    std::uint32_t bits(std::uint32_t value, std::uint32_t count) {
        range_.put_bits(value, count);
        return value;
    }
    void finish() { range_.finish(); }

  private:
    static constexpr std::uint32_t none = 0xffff'ffff;

    std::span<const CountChange>::iterator next_;
    std::span<const CountChange>::iterator end_;
    RangeEncoder range_;
};

class ChangeCoder::Read {
  public:
    Read(std::string_view payload, std::vector<CountChange>& changes)
        : range_(std::as_bytes(std::span(payload))), changes_(changes) {}

    CountChange next() const { return {0, 0}; }
    void took(const CountChange& change) { changes_.push_back(change); }
    bool bit(Bit& model, bool) {
        const std::uint32_t part = chance(model);
        const bool one = range_.find(certain) < part;
        range_.take(one ? 0 : part, one ? part : certain - part);
        learn(model, one);
        return one;
    }
    std::uint32_t bits(std::uint32_t, std::uint32_t count) { return range_.take_bits(count); }
    bool used_all() const { return range_.used_all(); }

  private:
    RangeDecoder range_;
    std::vector<CountChange>& changes_;
};

ChangeCoder::ChangeCoder(std::uint32_t elements, bool slopes) : slopes_(slopes), elements_(elements) {}

std::size_t ChangeCoder::context(const Element& element, std::uint32_t neighbours) const noexcept {
    const std::uint32_t age = scan_ - element.last;
    const std::size_t octave = std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(age)), ages - 1);
    // How near the interval before is to its end again.
    const std::uint32_t before = element.interval;
    const std::size_t due = before == 0 ? 0 : 4 * age < 3 * before ? 1 : 2 * age <= 3 * before ? 2 : 3;
    return (octave * 4 + due) * 4 + neighbours;
}

template <class Ends>
bool ChangeCoder::number(Ends& ends, Number& model, std::uint32_t& value) {
    const auto highest = static_cast<std::uint32_t>(std::bit_width(value + 1)) - 1;
    std::uint32_t exponent = 0;
    while (ends.bit(model.exponent[exponent], exponent < highest))
        if (++exponent == most_exponent) return false;
    std::uint32_t found = 1;
    for (std::uint32_t left = exponent; left > 0;) {
        if (exponent - left == learnt) {
            found = found << left | ends.bits((value + 1) & ((1U << left) - 1), left);
            break;
        }
        --left;
        Bit& bit = model.rest[exponent][found & ((1U << learnt) - 1)];
        found = found << 1 | static_cast<std::uint32_t>(ends.bit(bit, ((value + 1) >> left & 1) == 1));
    }
    value = found - 1;
    return true;
}

template <class Ends>
bool ChangeCoder::walk(Ends& ends, std::uint32_t scans) {
    const auto count = static_cast<std::uint32_t>(elements_.size());
    const auto sign_context = [](std::int32_t sign) {
        return static_cast<std::size_t>(std::int64_t{sign} + 1);
    };
    for (std::uint32_t scan = 0; scan < scans; ++scan, ++scan_) {
        std::uint32_t neighbours = 0;  // of the two before, which have changed
        std::int32_t sign = 0;
        for (std::uint32_t e = 0; e < count; ++e) {
            Element& element = elements_[e];
            CountChange change = ends.next();
            const std::uint32_t at = scan * count + e;
            const bool changed = ends.bit(changed_[context(element, neighbours)], change.element == at);
            neighbours = (neighbours << 1 | static_cast<std::uint32_t>(changed)) & 3;
            if (!changed) continue;
            Bit& negative = negative_[3 * sign_context(element.sign) + sign_context(sign)];
            const bool falls = ends.bit(negative, change.amount < 0);
            std::uint32_t size = static_cast<std::uint32_t>(std::abs(change.amount)) - 1;
            if (!number(ends, amount_[std::min<std::size_t>(element.size, amount_.size() - 1)], size))
                return false;
            sign = falls ? -1 : 1;
            change = {at, sign * static_cast<std::int32_t>(size + 1), change.slope};
            if (slopes_) {
                if (ends.bit(level_[falls], change.slope == 0)) {
                    change.slope = 0;
                } else {
                    const bool down = ends.bit(falling_[falls], change.slope < 0);
                    std::uint32_t steep = static_cast<std::uint32_t>(std::abs(change.slope)) - 1;
                    if (!number(ends, slope_, steep)) return false;
                    change.slope = (down ? -1 : 1) * static_cast<std::int32_t>(steep + 1);
                }
            }
            element = {.last = scan_,
                       .interval = element.last == 0 ? 0 : scan_ - element.last,
                       .sign = static_cast<std::int8_t>(sign),
                       .size = static_cast<std::uint8_t>(std::bit_width(size + 1))};
            ends.took(change);
        }
    }
    return true;
}

void ChangeCoder::encode(std::span<const CountChange> changes, std::uint32_t scans, std::string& payload) {
    payload.clear();
    if (changes.empty()) {
        scan_ += scans;
        return;
    }
    Write ends(changes, payload);
    walk(ends, scans);
    ends.finish();
    // Zeros alone are left out, and no payload means no change.
    if (payload.empty()) payload.push_back('\0');
}

bool ChangeCoder::decode(std::string_view payload, std::uint32_t scans, std::vector<CountChange>& changes) {
    changes.clear();
    if (payload.empty()) {
        scan_ += scans;
        return true;
    }
    Read ends(payload, changes);
    return walk(ends, scans) && ends.used_all();
}

}  // namespace afferent
