#include "afferent/io/wire/spike_predictor.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "afferent/io/wire/range_coder.hpp"
#include "afferent/io/wire/spike_chances.hpp"

namespace afferent {
namespace {

// A spike that comes earlier than so many spreads before the foreseen one is listed; so is one that comes
// later than so many after it, and it is not waited for any longer.
constexpr std::int64_t spreads_before = 5;
constexpr std::int64_t spreads_after = 24;

// Where the interval before is not one of a held drive, of an afferent that fires for the first time or after
// a pause.
constexpr std::uint32_t unsure = 4;  // a spread of a quarter of the interval
constexpr std::uint32_t sure = 32;

// Levels are natural logarithms in 2^-12. An interval is changed by no more than by its quarter.
constexpr int level_bits = 12;
constexpr std::int64_t most_change = 1 << (level_bits - 2);
// So many spikes of a span count as much as what was known before.
constexpr std::int64_t inertia = 4;

// How much a patch follows the others is learned by normalised least mean squares: the noise of a change,
// squared, and how many changes it takes.
constexpr std::int64_t change_noise = 1024;
constexpr std::int64_t learned_after = 16;

}  // namespace

void SpikePredictor::Group::settle(const Change& all) noexcept {
    const Change others{all.gained - own.gained, all.spikes - own.spikes};
    const std::int64_t gained = std::int64_t{alike} * own.gained + follows * others.gained;
    const std::int64_t spikes = std::int64_t{alike} * own.spikes + follows * others.spikes;
    if (gained != 0) level = static_cast<std::uint16_t>(level + gained / (spikes + alike * inertia));
    if (own.spikes > 0 && others.spikes > 0) {
        const std::int64_t here = own.gained / own.spikes;
        const std::int64_t there = others.gained / others.spikes;
        const std::int64_t missed = alike * here - follows * there;
        const std::int64_t step = there * missed / (there * there + change_noise) / learned_after;
        follows = static_cast<std::uint16_t>(std::clamp<std::int64_t>(follows + step, 0, alike));
    }
    own = {};
}

void SpikePredictor::settle_levels() noexcept {
    std::fill(changes_.begin(), changes_.end(), Change{});
    for (const Group& group : groups_) {
        changes_[group.law].gained += group.own.gained;
        changes_[group.law].spikes += group.own.spikes;
    }
    for (Group& group : groups_) group.settle(changes_[group.law]);
}

// The interval until the spike that is foreseen, as the drives of all have changed since the last one: by as
// much less as they are more.
inline std::uint32_t SpikePredictor::interval_now(const Afferent& afferent, const Group& group) noexcept {
    const std::int64_t change = std::clamp<std::int64_t>(
        static_cast<std::int16_t>(group.level - afferent.level), -most_change, most_change);
    return static_cast<std::uint32_t>(afferent.interval -
                                      (std::int64_t{afferent.interval} * change >> level_bits));
}

inline std::int64_t SpikePredictor::due(const Afferent& afferent, const Group& group) const noexcept {
    return static_cast<std::int32_t>(afferent.last + interval_now(afferent, group) - begin_);
}

// How long after it was foreseen a spike is waited for.
inline std::int64_t SpikePredictor::patience(const Afferent& afferent) const noexcept {
    return spreads_after * 2 * std::int64_t{afferent.spread} + 64 + 32 * std::int64_t{tolerance_};
}

// Whether the afferent has a symbol in what is left of the span, or is listed.
inline bool SpikePredictor::is_near(const Afferent& afferent, std::int64_t due_at,
                                    std::int64_t from) const noexcept {
    if (afferent.interval == 0) return false;
    const std::int64_t spread = 2 * std::int64_t{afferent.spread};
    return due_at - spreads_before * spread < 16 * std::int64_t{span_ticks_} &&
           16 * from < due_at + patience(afferent);
}

// Where in a span one afferent may fire, in ticks since its begin. The ticks of what is left of the span have
// a symbol each, but for those within the tolerance of the foreseen one, which share theirs.
struct SpikePredictor::Window {
    std::int64_t begin;  // of what is left of the span
    std::int64_t end;    // of the span
    std::int64_t due;    // when the spike is foreseen, in sixteenths
    SpikeChances chances;
    std::uint64_t tolerance;
    std::int64_t foreseen;    // the tick that stands for those from near_begin to near_end
    std::int64_t near_begin;  // none of them: near_end
    std::int64_t near_end;
    std::int64_t waits_from = std::numeric_limits<std::int64_t>::max();
    std::uint32_t symbols;  // of spikes
    std::uint32_t before;   // the chance of what is past already
    std::uint32_t without;  // where the symbol of no spike begins
    std::uint32_t total;

    Window(std::int64_t from, std::int64_t span_ticks, std::int64_t due_at, std::uint32_t missed,
           std::uint32_t within) noexcept
        : begin(from),
          end(span_ticks),
          due(due_at),
          chances(missed),
          tolerance(within),
          foreseen((due_at + 8) >> 4) {
        const auto around = std::int64_t{within};
        // Whether a spike came as foreseen must be known by the end of the span: near that the foreseen tick
        // is moved into the next span, and is the first there. A spike that comes before waits for it.
        if (foreseen < end && foreseen >= end - around) {
            foreseen = end;
            waits_from = end - around;
        }
        if (foreseen < begin && foreseen >= begin - around) foreseen = begin;
        const bool inside = foreseen >= begin && foreseen < end;
        near_begin = inside ? std::max(foreseen - around, begin) : begin;
        near_end = inside ? std::min(foreseen + around + 1, end) : begin;
        symbols =
            static_cast<std::uint32_t>(end - begin - std::max<std::int64_t>(0, near_end - near_begin - 1));
        before = chances.until(edge(begin));
        without = low(symbols);
        // Rounding leaves each symbol its own unit; with as many for no spike, they do not add up to a likely
        // one.
        total = SpikeChances::scale - before + 2 * symbols + 1;
    }

    bool is_near(std::int64_t tick) const noexcept { return tick >= near_begin && tick < near_end; }
    std::uint32_t symbol(std::int64_t tick) const noexcept {
        if (is_near(tick)) return static_cast<std::uint32_t>(near_begin - begin);
        if (tick < near_begin) return static_cast<std::uint32_t>(tick - begin);
        return symbols - static_cast<std::uint32_t>(end - tick);
    }
    // The tick that is told by it, and its first.
    std::int64_t tick(std::uint32_t symbol) const noexcept {
        const std::int64_t first = first_tick(symbol);
        return is_near(first) ? foreseen : first;
    }
    std::int64_t first_tick(std::uint32_t symbol) const noexcept {
        const std::int64_t tick = begin + symbol;
        return tick <= near_begin ? tick : tick + (end - begin) - symbols;
    }
    // Where a symbol begins in `total`.
    std::uint32_t low(std::uint32_t symbol) const noexcept {
        return chances.until(edge(first_tick(symbol))) - before + symbol;
    }
    struct Part {
        std::uint32_t low, frequency;
    };
    // What a symbol takes of `total`.
    Part part(std::uint32_t symbol) const noexcept {
        if (symbol == symbols) return {without, total - without};
        const std::uint32_t begins = low(symbol);
        return {begins, (symbol + 1 == symbols ? without : low(symbol + 1)) - begins};
    }
    // `symbols`: no spike. None is presumed to the tick: it would come true too seldom to be worth the wait.
    std::uint32_t presumed() const noexcept {
        if (near_end - near_begin <= 1) return symbols;
        const std::uint32_t near = symbol(near_begin);
        return 2 * part(near).frequency >= total ? near : symbols;
    }

  private:
    // The begin of a tick from when the spike is foreseen: a stamp is the whole tick around it.
    std::int64_t edge(std::int64_t tick) const noexcept { return tick * 16 - 8 - due; }
};

static_assert(most_total == 1 << static_cast<int>(SpikePredictor::most_symbol_bits));

class SpikePredictor::Encode {
  public:
    Encode(SpikePredictor& self, std::string& payload, bool last)
        : self_(self), range_(payload), next_(self.by_address_.begin()), last_(last) {
        self_.unforeseen_.clear();
    }

    std::uint32_t symbol(Address address, const Window& window) {
        const std::uint64_t first = std::uint64_t{address} * self_.span_ticks_;
        while (next_ != self_.by_address_.end() && *next_ < first) self_.unforeseen_.push_back(*next_++);
        std::uint32_t symbol = window.symbols;
        const auto last = std::find_if(next_, self_.by_address_.end(), [&](std::uint64_t event) {
            return event >= first + self_.span_ticks_;
        });
        const bool crowded = last - next_ > 1 && next_[1] - next_[0] <= window.tolerance;
        if (crowded || (next_ != last && has_waited_in_vain(first, window))) {
            // Otherwise the first may be told for a time after the second, or after what the tolerance
            // allows.
            self_.unforeseen_.insert(self_.unforeseen_.end(), next_, last);
            next_ = last;
        } else if (next_ != last) {
            const auto tick = static_cast<std::int64_t>(*next_ - first);
            if (tick >= window.waits_from && last - next_ == 1 && !last_)
                self_.waiting_.push_back(first);
            else
                symbol = window.symbol(tick);
            ++next_;
        }
        const Window::Part part = window.part(symbol);
        range_.put(part.low, part.frequency, window.total);
        if (symbol != window.presumed()) surprised_ = true;
        return symbol;
    }

    template <class Fire>
    void list(const Fire& fire) {
        self_.unforeseen_.insert(self_.unforeseen_.end(), next_, self_.by_address_.end());
        std::span<const std::uint64_t> left = self_.unforeseen_;
        const std::uint32_t chance = self_.surprising_;
        range_.put(left.empty() ? chance : 0, left.empty() ? 4096 - chance : chance, 4096);
        if (left.empty()) return;
        surprised_ = true;
        // The count less one, in units of what it was before and a remainder; then gaps of addresses alike.
        rice(static_cast<std::uint32_t>(left.size()) - 1, self_.count_bits());
        const std::uint32_t gap_bits = self_.gap_bits(left.size());
        Address before = 0;
        for (const std::uint64_t event : left) {
            const auto address = static_cast<Address>(event / self_.span_ticks_);
            const auto tick = static_cast<std::uint32_t>(event % self_.span_ticks_);
            rice(address - before, gap_bits);
            range_.put(tick, 1, self_.span_ticks_);
            before = address;
            fire(address, tick);
        }
    }

    bool finish() {
        self_.information_bits_ = range_.bits();
        range_.finish();
        return surprised_;
    }

  private:
    // It came before the span, and is foreseen for later than its begin now.
    bool has_waited_in_vain(std::uint64_t first, const Window& window) const {
        return *next_ == first && window.is_near(0) && window.foreseen > 0 &&
               std::binary_search(self_.waited_.begin(), self_.waited_.end(), first);
    }

    void rice(std::uint32_t value, std::uint32_t bits) {
        for (std::uint32_t unary = value >> bits; unary > 0; --unary) range_.put(1, 1, 2);
        range_.put(0, 1, 2);
        if (bits > 16) range_.put_bits(value >> 16 & ((1U << (bits - 16)) - 1), bits - 16);
        range_.put_bits(value & ((1U << std::min(bits, 16U)) - 1), std::min(bits, 16U));
    }

    SpikePredictor& self_;
    RangeEncoder range_;
    std::vector<std::uint64_t>::iterator next_;
    bool last_;
    bool surprised_ = false;
};

class SpikePredictor::Decode {
  public:
    Decode(SpikePredictor& self, std::span<const std::byte> payload) : self_(self), range_(payload) {}

    std::uint32_t symbol(Address, const Window& window) {
        const std::uint32_t at = range_.find(window.total);
        std::uint32_t found = window.symbols;  // by far the likeliest
        if (at < window.without) {
            found = 0;
            for (std::uint32_t end = window.symbols; end - found > 1;) {
                const std::uint32_t middle = (found + end) / 2;
                (window.low(middle) <= at ? found : end) = middle;
            }
        }
        const Window::Part part = window.part(found);
        range_.take(part.low, part.frequency);
        return found;
    }

    template <class Fire>
    void list(const Fire& fire) {
        const std::uint32_t chance = self_.surprising_;
        if (range_.find(4096) >= chance) return range_.take(chance, 4096 - chance);
        range_.take(0, chance);
        const std::uint64_t count = std::uint64_t{rice(self_.count_bits(), self_.max_events_)} + 1;
        const std::uint32_t gap_bits = self_.gap_bits(count);
        std::uint64_t address = 0;
        for (std::uint64_t i = 0; i < count && !failed_; ++i) {
            address += rice(gap_bits, self_.addresses_);
            const std::uint32_t tick = range_.find(self_.span_ticks_);
            range_.take(tick, 1);
            if (address >= self_.addresses_ || self_.codes_.size() >= self_.max_events_) failed_ = true;
            if (!failed_) fire(static_cast<Address>(address), tick);
        }
    }

    bool failed() const noexcept { return failed_ || !range_.used_all(); }

  private:
    // More than `most` is refused.
    std::uint32_t rice(std::uint32_t bits, std::uint32_t most) {
        std::uint64_t value = 0;
        while (range_.take_bits(1) == 1) {
            value += std::uint64_t{1} << bits;
            if (value <= most) continue;
            failed_ = true;
            return 0;
        }
        if (bits > 16) value += std::uint64_t{range_.take_bits(bits - 16)} << 16;
        value += range_.take_bits(std::min(bits, 16U));
        if (value > most) failed_ = true;
        return failed_ ? 0 : static_cast<std::uint32_t>(value);
    }

    SpikePredictor& self_;
    RangeDecoder range_;
    bool failed_ = false;
};

class SpikePredictor::Presume {
  public:
    std::uint32_t symbol(Address, const Window& window) { return window.presumed(); }
    template <class Fire>
    void list(const Fire&) {}
};

SpikePredictor::SpikePredictor(const PacketLayout& layout)
    : span_ticks_(static_cast<std::uint32_t>(layout.span / layout.tick)),
      tolerance_(static_cast<std::uint32_t>(layout.tolerance / layout.tick)),
      max_events_(layout.max_events) {
    layout.check();
    std::vector<NeuronLaw> known;
    std::vector<IntervalLaw> laws;
    for (const NeuronGroup& group : layout.neurons) {
        const auto same = std::find(known.begin(), known.end(), group.law);
        addresses_ += group.addresses;
        groups_.push_back({.end = addresses_, .law = static_cast<std::uint32_t>(same - known.begin())});
        if (same != known.end()) continue;
        laws.emplace_back(group.law, layout.tick);
        known.push_back(group.law);
    }
    changes_.resize(laws.size());
    laws_ = std::make_shared<const std::vector<IntervalLaw>>(std::move(laws));
    afferents_.resize(addresses_);
    active_.resize((std::size_t{addresses_} + 63) / 64);
    codes_.reserve(max_events_);
    told_.reserve(max_events_);
    by_address_.reserve(max_events_);
    unforeseen_.reserve(max_events_);
    waiting_.reserve(max_events_);
    waited_.reserve(max_events_);
    restart(0);
}

// Each afferent has one symbol that it did not fire, and each event one; those that are listed have two more:
// the gap of the address, less than 2 bits above that of the mean, and the tick.
std::size_t SpikePredictor::most_bytes(const PacketLayout& layout) {
    const double events = layout.max_events;
    const double addresses = layout.addresses;
    const double gap_bits = std::log2(1 + addresses / events) + 3;
    const double bits = most_symbol_bits * (addresses + events) + events * (gap_bits + 16) + 64;
    return static_cast<std::size_t>(bits / 8) + 16;
}

void SpikePredictor::restart(std::uint64_t ticks) {
    std::fill(afferents_.begin(), afferents_.end(), Afferent{});
    std::fill(active_.begin(), active_.end(), 0);
    calendar_.fill(nobody);
    span_ = ticks / span_ticks_;
    begin_ = static_cast<std::uint32_t>(16 * ticks);
    surprising_ = 2048;
    surprises_ = 16;
    check_ = 0;
    for (Group& group : groups_) group = {.end = group.end, .law = group.law};
}

bool SpikePredictor::encode(std::span<const Code> codes, std::string& payload, Manner manner) {
    assert(codes.size() + waiting_.size() <= max_events_);
    by_address_.assign(waiting_.begin(), waiting_.end());
    waited_.swap(waiting_);
    waiting_.clear();
    for (const Code code : codes)
        by_address_.push_back(std::uint64_t{code % addresses_} * span_ticks_ + code / addresses_);
    sorter_.sort(by_address_);
    Encode coder(*this, payload, manner.last);
    walk(coder, manner.exactly ? 0 : tolerance_);
    if (!coder.finish() && !manner.exactly) {
        payload.clear();
        return false;
    }
    // Zeros alone are left out, and no payload means that nothing is other than presumed.
    if (payload.empty()) payload.push_back('\0');
    return true;
}

Result<std::span<const Code>> SpikePredictor::decode(std::span<const std::byte> payload, bool exactly) {
    if (payload.empty()) return presume();
    Decode coder(*this, payload);
    walk(coder, exactly ? 0 : tolerance_);
    if (coder.failed()) return Error{Error::Kind::malformed, "payload: tells of no spikes that can be"};
    return sorted();
}

std::span<const Code> SpikePredictor::presume() {
    Presume coder;
    walk(coder, tolerance_);
    return sorted();
}

void SpikePredictor::learn(std::span<const Told> spikes) {
    told_.assign(spikes.begin(), spikes.end());
    std::ranges::sort(told_, {},
                      [](const Told& told) { return std::tuple(told.address, told.tick, told.as_foreseen); });
    auto next = told_.begin();
    const auto take = [&](Address address, Group& group) {
        Afferent& afferent = afferents_[address];
        for (; next != told_.end() && next->address == address; ++next) {
            if (next->as_foreseen && afferent.fired)
                follow_told(afferent, group, next->tick);
            else
                foresee(afferent, group, next->tick, false);
            count_in_check(address);
        }
        settle(address, group);
    };
    const auto take_before = [&](Address end) {
        while (next != told_.end() && next->address < end) take(next->address, group_of(next->address));
    };
    visit_active([&](Address address, Group& group) {
        take_before(address);
        take(address, group);
    });
    take_before(addresses_);
    settle_levels();
    end_span();
}

void SpikePredictor::skip() {
    visit_active([&](Address address, const Group& group) {
        pass_over(afferents_[address], group);
        settle(address, group);
    });
    end_span();
}

void SpikePredictor::foresee_as(const SpikePredictor& other) {
    std::vector<std::uint64_t> waiting = std::move(waiting_);
    *this = other;
    waiting_ = std::move(waiting);
}

void SpikePredictor::add(std::span<const Code> codes) {
    --span_;
    begin_ -= 16 * span_ticks_;
    codes_.clear();
    told_.clear();
    for (const Code code : codes) {
        const Address address = code % addresses_;
        fire(address, group_of(address), code / addresses_, false);
        settle(address, group_of(address));
    }
    end_span();
}

void SpikePredictor::end_span() noexcept {
    ++span_;
    begin_ += 16 * span_ticks_;
}

std::span<const Code> SpikePredictor::sorted() {
    sorter_.sort(codes_);
    return codes_;
}

// By address, each afferent that may fire in the span that begins.
template <class Visit>
void SpikePredictor::visit_active(const Visit& visit) {
    wake();
    Group* group = groups_.data();
    for (std::size_t word = 0; word < active_.size(); ++word)
        for (std::uint64_t bits = active_[word]; bits != 0; bits &= bits - 1) {
            const auto address =
                static_cast<Address>(word * 64 + static_cast<unsigned>(std::countr_zero(bits)));
            while (address >= group->end) ++group;
            visit(address, *group);
        }
}

// The same at both ends, symbol by symbol: the coder alone knows whether they are written, read or presumed.
template <class Coder>
void SpikePredictor::walk(Coder& coder, std::uint32_t tolerance) {
    codes_.clear();
    told_.clear();
    visit_active([&](Address address, Group& group) {
        const Afferent& afferent = afferents_[address];
        std::int64_t from = 0;
        std::int64_t due_at = due(afferent, group);
        while (codes_.size() < max_events_ && is_near(afferent, due_at, from)) {
            const Window window(from, span_ticks_, due_at, afferent.spread, tolerance);
            const std::uint32_t symbol = coder.symbol(address, window);
            if (symbol == window.symbols) break;
            from = window.tick(symbol);
            fire(address, group, static_cast<std::uint32_t>(from), tolerance > 0 && window.is_near(from));
            due_at = due(afferent, group);
        }
        settle(address, due_at);
    });
    const std::size_t foreseen = codes_.size();
    coder.list([&](Address address, std::uint32_t tick) {
        fire(address, group_of(address), tick, false);
        settle(address, group_of(address));
    });
    const auto listed = static_cast<std::uint32_t>(codes_.size() - foreseen);
    const std::uint32_t aim = listed > 0 ? 4096 - 32 : 32;
    surprising_ = surprising_ + aim / 16 - surprising_ / 16;
    if (listed > 0) surprises_ = surprises_ - surprises_ / 4 + listed * 4;
    settle_levels();
    end_span();
}

void SpikePredictor::fire(Address address, Group& group, std::uint32_t tick, bool as_foreseen) noexcept {
    codes_.push_back(tick * addresses_ + address);
    told_.push_back({address, static_cast<std::uint16_t>(tick), as_foreseen});
    foresee(afferents_[address], group, tick, as_foreseen);
    count_in_check(address);
}

void SpikePredictor::count_in_check(Address address) noexcept {
    const Afferent& afferent = afferents_[address];
    const std::uint32_t told = check_ ^ afferent.last ^ std::rotl(afferent.interval, 16) ^ address;
    check_ = (told ^ told >> 15) * 0x2c1b'3c6d;
}

void SpikePredictor::foresee(Afferent& afferent, Group& group, std::uint32_t tick,
                             bool as_foreseen) noexcept {
    const IntervalLaw& intervals = (*laws_)[group.law];
    if (as_foreseen) {
        // Neither end knows by how much it was missed: both go on as if by nothing.
        const std::uint32_t waited = interval_now(afferent, group);
        if (waited != afferent.interval) afferent.drive = intervals.drive(waited, afferent.g);
        afferent.level = group.level;
        ++group.own.spikes;
        afferent.last += waited;
        afferent.g = intervals.next_adaptation(afferent.g, waited / 16);
        afferent.interval = intervals.interval(afferent.drive, afferent.g, waited);
        afferent.spread = static_cast<std::uint16_t>(SpikeChances::after(afferent.spread, 8 * tolerance_));
        if (afferent.held < 63) ++afferent.held;
        return;
    }
    const std::uint32_t now = begin_ + 16 * tick;
    // With a tolerance, a spike may be told for an earlier tick than the one before it.
    const std::uint32_t interval =
        afferent.last - now < 16 * span_ticks_ ? 16 : std::max(now - afferent.last, 16U);
    if (afferent.fired && interval < 16 * IntervalLaw::longest) {
        const std::uint32_t waited = interval_now(afferent, group);
        const std::int64_t late = std::int64_t{interval} - waited;
        if (afferent.interval > 0) {
            group.own.gained -=
                std::clamp<std::int64_t>(late * (1 << level_bits) / waited, -most_change, most_change);
            ++group.own.spikes;
            afferent.spread = static_cast<std::uint16_t>(
                SpikeChances::after(afferent.spread, static_cast<std::uint32_t>(late < 0 ? -late : late)));
            // All intervals since the last spike whose tick is known have added up to that.
            afferent.drive = intervals.drive(
                static_cast<std::uint32_t>(std::int64_t{waited} + late / std::int64_t{afferent.held + 1}),
                afferent.g);
        } else {
            afferent.spread = static_cast<std::uint16_t>(std::clamp(interval / 2 / sure, 1U, 0xffffU));
            afferent.drive = intervals.drive(interval, afferent.g);
        }
        afferent.g = intervals.next_adaptation(afferent.g, interval / 16);
        const std::int64_t change = std::int64_t{afferent.drive} - group.drive;
        group.drive = group.drive == 0 ? afferent.drive
                                       : static_cast<std::uint32_t>(std::int64_t{group.drive} + change / 16);
        afferent.interval = intervals.interval(afferent.drive, afferent.g, interval);
    } else {
        afferent.g = intervals.first_adaptation();
        afferent.drive = group.drive;
        afferent.interval = group.drive == 0 ? 0 : intervals.interval(group.drive, afferent.g);
        afferent.spread = static_cast<std::uint16_t>(std::clamp(afferent.interval / 2 / unsure, 1U, 0xffffU));
    }
    afferent.last = now;
    afferent.level = group.level;
    afferent.held = 0;
    afferent.fired = true;
}

// A spike that another predictor has foreseen for this tick: it says that the drive still holds, and no more.
void SpikePredictor::follow_told(Afferent& afferent, const Group& group, std::uint32_t tick) noexcept {
    const std::uint32_t now = begin_ + 16 * tick;
    const std::uint32_t interval =
        afferent.last - now < 16 * span_ticks_ ? 16 : std::max(now - afferent.last, 16U);
    afferent.last = now;
    afferent.level = group.level;
    afferent.g = (*laws_)[group.law].next_adaptation(afferent.g, interval / 16);
    afferent.interval = (*laws_)[group.law].interval(afferent.drive, afferent.g, interval);
    if (afferent.held < 63) ++afferent.held;
}

// Assumes that the spikes came when they were foreseen. The expected miss grows in proportion to the number
// of intervals for which nothing was told.
void SpikePredictor::pass_over(Afferent& afferent, const Group& group) noexcept {
    while (afferent.interval > 0 && due(afferent, group) < 16 * std::int64_t{span_ticks_}) {
        const std::uint32_t waited = std::max(interval_now(afferent, group), 16U);
        afferent.last += waited;
        afferent.g = (*laws_)[group.law].next_adaptation(afferent.g, waited / 16);
        afferent.interval = (*laws_)[group.law].interval(afferent.drive, afferent.g, waited);
        const std::uint32_t spread = afferent.spread + afferent.spread / (std::uint32_t{afferent.held} + 1);
        afferent.spread =
            static_cast<std::uint16_t>(std::min<std::uint32_t>(spread, SpikeChances::most_spread));
        if (afferent.held < 63) ++afferent.held;
    }
}

// After its symbols of a span: whether it has one in the next, or when it will.
void SpikePredictor::settle(Address address, std::int64_t due_at) noexcept {
    Afferent& afferent = afferents_[address];
    const std::int64_t span = 16 * std::int64_t{span_ticks_};
    if (span >= due_at + patience(afferent)) afferent.interval = 0;
    // From the end of the span until it is near.
    const std::int64_t ahead = due_at - 2 * spreads_before * afferent.spread - span;
    if (afferent.interval > 0 && (ahead < 2 * span || afferent.listed)) return activate(address);
    active_[address / 64] &= ~(std::uint64_t{1} << address % 64);
    if (afferent.interval == 0) return;
    const auto spans = static_cast<std::uint64_t>(std::min<std::int64_t>(ahead / span, places - 1));
    std::uint32_t& place = calendar_[(span_ + spans) % places];
    afferent.next = place & nobody;
    afferent.listed = true;
    place = address;
}

void SpikePredictor::wake() noexcept {
    std::uint32_t& place = calendar_[span_ % places];
    for (std::uint32_t address = place; address != nobody;) {
        Afferent& afferent = afferents_[address];
        afferent.listed = false;
        activate(address);
        address = afferent.next;
    }
    place = nobody;
}

SpikePredictor::Group& SpikePredictor::group_of(Address address) noexcept {
    return *std::partition_point(groups_.begin(), groups_.end(),
                                 [address](const Group& group) { return group.end <= address; });
}

std::uint32_t SpikePredictor::count_bits() const noexcept {
    return static_cast<std::uint32_t>(std::bit_width(surprises_ / 16));
}

std::uint32_t SpikePredictor::gap_bits(std::uint64_t count) const noexcept {
    const std::uint64_t gap = std::uint64_t{addresses_} * 2 / (3 * count);
    return gap == 0 ? 0 : static_cast<std::uint32_t>(std::bit_width(gap)) - 1;
}

}  // namespace afferent
