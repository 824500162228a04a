#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "afferent/neurons/dense_kernel.cpp"
#include <hwy/foreach_target.h>  // includes this file once for every instruction set
#include <hwy/highway.h>
// Must follow highway.h.
#include <hwy/contrib/math/math-inl.h>

#include <hwy/cache_control.h>

#include <algorithm>
#include <type_traits>

#include "afferent/neurons/dense_kernel.hpp"

#ifndef AFFERENT_PACKING_TABLE
#define AFFERENT_PACKING_TABLE
namespace afferent::dense {

// For each set of lanes: the chosen lanes first; the rest is arbitrary.
alignas(64) inline constexpr auto packing_table = [] {
    std::array<std::array<std::int64_t, max_lanes>, 1 << max_lanes> table{};
    for (std::size_t set = 0; set < table.size(); ++set)
        for (std::size_t lane = 0, at = 0; lane < max_lanes; ++lane)
            if ((set >> lane & 1) != 0) table[set][at++] = static_cast<std::int64_t>(lane);
    return table;
}();

}  // namespace afferent::dense
#endif

HWY_BEFORE_NAMESPACE();
namespace afferent::dense::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, max_lanes>;
using I = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<I>;
using M = hn::Mask<D>;

constexpr D d;
constexpr I di;

HWY_INLINE V constant(double value) { return hn::Set(d, value); }

// The constants of one vector of neurons, whether they differ or not.
struct Element {
    V v_th;
    V reversal;   // W = v_th − E_k
    V reset_gap;  // v_th − v_r
    V lost;       // v_th − v_r − reset_gap, exactly
    V delta_g;
};

HWY_INLINE Element element(const Model& model, V v_th, V delta_g) {
    const V v_r = constant(model.v_r_mv);
    const V reset_gap = hn::Sub(v_th, v_r);
    const V v_r_seen = hn::Sub(v_th, reset_gap);
    const V v_th_seen = hn::Add(reset_gap, v_r_seen);
    const V lost = hn::Sub(hn::Sub(v_th, v_th_seen), hn::Sub(v_r, v_r_seen));
    return {v_th, hn::Sub(v_th, constant(model.e_k_mv)), reset_gap, lost, delta_g};
}

HWY_INLINE Element common_element(const Model& model, const Neurons& neurons) {
    return element(model, constant(neurons.common_v_th_mv), constant(neurons.common_delta_g));
}

HWY_INLINE V excess(const Element& each, V drive) {
    return hn::Sub(hn::Sub(drive, each.reset_gap), each.lost);
}

// Moves the chosen lanes of several vectors to the front, by one table look-up each. (Highway's own Compress
// is slow here: compilers copy its table to the stack at every call.)
class Packing {
  public:
    HWY_INLINE explicit Packing(M mask) : count(hn::CountTrue(d, mask)), order(look_up(mask)) {}

    // Writes a whole vector.
    HWY_INLINE void put(V values, double* to) const {
        hn::StoreU(hn::TableLookupLanes(values, order), d, to);
    }
    HWY_INLINE void put(VI values, std::int64_t* to) const {
        hn::StoreU(hn::BitCast(di, hn::TableLookupLanes(hn::BitCast(d, values), order)), di, to);
    }

    const std::size_t count;

  private:
    using Order = decltype(hn::IndicesFromVec(d, VI()));
    static HWY_INLINE Order look_up(M mask) {
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(d, mask, bits);
        return hn::IndicesFromVec(d, hn::Load(di, packing_table[bits[0]].data()));
    }

    const Order order;
};

// One vector of a batch.
struct Item {
    V gap, g, excess, end, left, elapsed;
    VI index;
};

// The lanes of the vector at `at` that are in the batch.
HWY_INLINE M lanes_in(const Batch& batch, std::size_t at) {
    return hn::FirstN(d, batch.size - std::min(batch.size, at));
}

// The vector at `at`. Where the batch ends within it, the remaining lanes are copies of the first lane, so
// that storing their results writes the first lane's results once more. A vector behind the end is a copy of
// the one at `begin`, for the same reason.
HWY_INLINE Item load(const Batch& batch, std::size_t begin, std::size_t at) {
    if (at >= batch.size) at = begin;
    Item item{hn::Load(d, batch.gap_mv.data() + at),    hn::Load(d, batch.g.data() + at),
              hn::Load(d, batch.excess_mv.data() + at), hn::Load(d, batch.end_mv.data() + at),
              hn::Load(d, batch.left.data() + at),      hn::Load(d, batch.elapsed.data() + at),
              hn::Load(di, batch.index.data() + at)};
    if (batch.size - at >= hn::Lanes(d)) return item;
    const M real = lanes_in(batch, at);
    for (V* const each : {&item.gap, &item.g, &item.excess, &item.end, &item.left, &item.elapsed})
        *each = hn::IfThenElse(real, *each, constant(hn::GetLane(*each)));
    item.index = hn::IfThenElse(hn::RebindMask(di, real), item.index, hn::Set(di, hn::GetLane(item.index)));
    return item;
}

HWY_INLINE void append(const Model& model, const Item& item, M mask, Batch& batch) {
    const std::size_t at = batch.size;
    const Packing packing(mask);
    packing.put(item.gap, batch.gap_mv.data() + at);
    if (model.adapts) packing.put(item.g, batch.g.data() + at);
    packing.put(item.excess, batch.excess_mv.data() + at);
    packing.put(item.end, batch.end_mv.data() + at);
    packing.put(item.left, batch.left.data() + at);
    packing.put(item.elapsed, batch.elapsed.data() + at);
    packing.put(item.index, batch.index.data() + at);
    batch.size += packing.count;
}

HWY_INLINE Element gathered(const Model& model, const Neurons& neurons, VI index) {
    if (neurons.v_th_mv == nullptr && neurons.delta_g == nullptr) return common_element(model, neurons);
    const auto own = [&](const double* numbers, double common) {
        return numbers == nullptr ? constant(common) : hn::GatherIndex(d, numbers, index);
    };
    return element(model, own(neurons.v_th_mv, neurons.common_v_th_mv),
                   own(neurons.delta_g, neurons.common_delta_g));
}

// ---------------------------------------------------------------------------------------------------------------------

// p(u) as its even and odd part: two independent chains of products instead of one.
HWY_INLINE V polynomial(const double* coefficients, int count, V u, V u_squared) {
    V odd = constant(coefficients[count - 1]);
    V even = constant(coefficients[count - 2]);
    for (int k = count - 4; k >= 0; k -= 2) {
        odd = hn::MulAdd(odd, u_squared, constant(coefficients[k + 1]));
        even = hn::MulAdd(even, u_squared, constant(coefficients[k]));
    }
    return hn::MulAdd(odd, u, even);
}

// Φ and X over the step.
struct StepFlow {
    V phi, x;
};

HWY_INLINE StepFlow step_flow(const IntervalPolynomials& fit, int count, V per_half, V g) {
    const V u = hn::MulSub(g, per_half, constant(1));
    const V u_squared = hn::Mul(u, u);
    return {polynomial(fit.phi.data(), count, u, u_squared),
            hn::Mul(g, polynomial(fit.chi.data(), count, u, u_squared))};
}

// `near_count`: of the coefficients of model.near; 0 without adaptation.
template <int near_count, bool individual>
void sweep(const Model& model, const Neurons& neurons, const double* drives_mv, std::size_t begin,
           std::size_t count, Batch& crossing, Batch& hard) {
    constexpr bool adapts = near_count > 0;
    constexpr std::size_t ahead = 128;  // neurons: processors do not look beyond a page
    const std::size_t lanes = hn::Lanes(d);
    const V one = constant(1);
    const V scale = constant(neurons.scale);
    const V near_max = constant(model.near.g_max);
    const V far_max = constant(model.far.g_max);
    const V near_half = constant(2 / model.near.g_max);
    const V far_half = constant(2 / model.far.g_max);
    Element each = common_element(model, neurons);
    // Made once: compilers put the numbers of an Iota on the stack one by one.
    VI index = hn::Iota(di, static_cast<std::int64_t>(begin));
    const VI next_vector = hn::Set(di, static_cast<std::int64_t>(lanes));
    std::size_t found = crossing.size;
    for (std::size_t i = 0; i < count; i += lanes) {
        const std::size_t at = begin + i;
        hwy::Prefetch(neurons.gap_mv + at + ahead);
        if constexpr (adapts) hwy::Prefetch(neurons.scaled_g + at + ahead);
        if constexpr (individual) hwy::Prefetch(neurons.v_th_mv + at + ahead);
        const V gap = hn::Load(d, neurons.gap_mv + at);
        if constexpr (individual) each = element(model, hn::Load(d, neurons.v_th_mv + at), hn::Zero(d));
        const V over = excess(each, hn::LoadU(d, drives_mv + i));
        V g = hn::Zero(d);
        V end;
        M goes;
        if constexpr (adapts) {
            g = hn::Mul(hn::Load(d, neurons.scaled_g + at), scale);
            StepFlow flow = step_flow(model.near, near_count, near_half, g);
            const M beyond_near = hn::Gt(g, near_max);
            M beyond_far = hn::FirstN(d, 0);
            if (HWY_UNLIKELY(!hn::AllFalse(d, beyond_near))) {
                // Each lane has its own polynomials, whatever the others have.
                const StepFlow far = step_flow(model.far, model.far.count, far_half, g);
                flow.phi = hn::IfThenElse(beyond_near, far.phi, flow.phi);
                flow.x = hn::IfThenElse(beyond_near, far.x, flow.x);
                beyond_far = hn::Gt(g, far_max);
            }
            const V psi = hn::Sub(hn::Sub(one, flow.phi), flow.x);
            end = hn::NegMulAdd(over, psi, hn::MulAdd(each.reversal, flow.x, hn::Mul(gap, flow.phi)));
            goes = hn::Not(hn::Gt(end, hn::Zero(d)));
            if (HWY_UNLIKELY(!hn::AllFalse(d, beyond_far))) {
                append(model, {gap, g, over, end, constant(model.fall), hn::Zero(d), index}, beyond_far,
                       hard);
                goes = hn::AndNot(beyond_far, goes);
            }
        } else {
            end = hn::NegMulAdd(over, constant(1 - model.decay), hn::Mul(gap, constant(model.decay)));
            goes = hn::Not(hn::Gt(end, hn::Zero(d)));
        }
        // Those that cross, or are hard, are stored once more later.
        hn::Store(end, d, neurons.gap_mv + at);
        // No branch: whether a vector has a crossing is random and would be mispredicted.
        const Packing packing(goes);
        packing.put(gap, crossing.gap_mv.data() + found);
        if constexpr (adapts) packing.put(g, crossing.g.data() + found);
        packing.put(over, crossing.excess_mv.data() + found);
        packing.put(end, crossing.end_mv.data() + found);
        packing.put(index, crossing.index.data() + found);
        found += packing.count;
        index = hn::Add(index, next_vector);
    }
    for (std::size_t i = crossing.size; i < found; i += lanes) {
        hn::StoreU(constant(adapts ? model.fall : model.decay), d, crossing.left.data() + i);
        hn::StoreU(hn::Zero(d), d, crossing.elapsed.data() + i);
    }
    crossing.size = found;
}

// ---------------------------------------------------------------------------------------------------------------------

// The mathematics of a crossing is written for T: a vector, a pair, or a pair of pairs. The chains of one
// vector's operations are long, and those of the others fill the gaps; more than four need more registers
// than there are.
constexpr int group_vectors = 4;

template <class Half>
struct Pair {
    Half first, second;
};
template <class Half>
Pair(Half, Half) -> Pair<Half>;

template <class X>
inline constexpr bool is_pair = false;
template <class Half>
inline constexpr bool is_pair<Pair<Half>> = true;

template <class X>
inline constexpr int vectors_of = 1;
template <class Half>
inline constexpr int vectors_of<Pair<Half>> = 2 * vectors_of<Half>;

template <class T>
HWY_INLINE T set(double value) {
    if constexpr (is_pair<T>) {
        const auto half = set<decltype(T::first)>(value);
        return {half, half};
    } else {
        return constant(value);
    }
}

// Highway's function, on one vector or on each of several.
#define AFFERENT_ON_PAIRS(name, function)                                                  \
    template <class X, class... Others>                                                    \
    HWY_INLINE auto name(X x, Others... others) {                                          \
        if constexpr (is_pair<X>)                                                          \
            return Pair{name(x.first, others.first...), name(x.second, others.second...)}; \
        else                                                                               \
            return hn::function(x, others...);                                             \
    }
AFFERENT_ON_PAIRS(abs, Abs)
AFFERENT_ON_PAIRS(neg, Neg)
AFFERENT_ON_PAIRS(add, Add)
AFFERENT_ON_PAIRS(sub, Sub)
AFFERENT_ON_PAIRS(mul, Mul)
AFFERENT_ON_PAIRS(div, Div)
AFFERENT_ON_PAIRS(mul_add, MulAdd)         // x y + z
AFFERENT_ON_PAIRS(mul_sub, MulSub)         // x y − z
AFFERENT_ON_PAIRS(neg_mul_add, NegMulAdd)  // z − x y
AFFERENT_ON_PAIRS(less, Lt)
AFFERENT_ON_PAIRS(at_most, Le)
AFFERENT_ON_PAIRS(both, And)
AFFERENT_ON_PAIRS(either, Or)
AFFERENT_ON_PAIRS(select, IfThenElse)  // mask, value where it is set, value where it is not
#undef AFFERENT_ON_PAIRS

HWY_INLINE bool all(M x) { return hn::AllTrue(d, x); }
template <class Half>
HWY_INLINE bool all(Pair<Half> x) {
    return all(x.first) && all(x.second);
}
HWY_INLINE bool none(M x) { return hn::AllFalse(d, x); }
template <class Half>
HWY_INLINE bool none(Pair<Half> x) {
    return none(x.first) && none(x.second);
}

constexpr auto inverse_factorials = [] {
    std::array<double, max_terms> values{1};
    for (std::size_t n = 1; n < values.size(); ++n) values[n] = values[n - 1] / static_cast<double>(n);
    return values;
}();

// NaN becomes `low`, on every machine.
template <class T>
HWY_INLINE T clamp(T value, T low, T high) {
    value = select(less(low, value), value, low);
    return select(less(value, high), value, high);
}

// Within 3e-4 of it, and the same on every machine: a division takes as long as ten other operations.
HWY_INLINE V rough_reciprocal(V value) {
    const V two = constant(2);
    V result = hn::BitCast(d, hn::Sub(hn::Set(di, 0x7FDE6238502484BA), hn::BitCast(di, value)));
    result = hn::Mul(result, hn::NegMulAdd(value, result, two));
    return hn::Mul(result, hn::NegMulAdd(value, result, two));
}
template <class Half>
HWY_INLINE Pair<Half> rough_reciprocal(Pair<Half> value) {
    return {rough_reciprocal(value.first), rough_reciprocal(value.second)};
}

// A neuron of ShortInterval, where its series begins.
template <class T>
struct Start {
    T x;
    T gap;
    T reversal;
    T drive;  // a c
};

// z at ε, by the series of ShortInterval with T_n = n! t_n,
//
//     T_(n+1) = ε (a + x − n) T_n + n ε² x T_(n−1),      z = Σ T_n / n!
//
// A lane ends with the terms that its own growth needs: its result does not depend on the others.
template <class T>
HWY_INLINE T flow(const Model& model, const Start<T>& from, T epsilon) {
    const T growth = mul(epsilon, add(set<T>(model.a), from.x));
    const T square = mul(mul(epsilon, epsilon), from.x);
    const T force = neg_mul_add(from.x, from.reversal, from.drive);
    T before = mul_add(growth, from.gap, mul(epsilon, force));
    T factor = sub(growth, epsilon);
    T term = mul_add(factor, before, mul(square, sub(from.gap, from.reversal)));
    const T head = add(from.gap, before);
    T tail = mul(set<T>(0.5), term);
    factor = sub(factor, epsilon);
    T weight = add(square, square);
    std::size_t n = 2;
    for (std::size_t level = 0;; ++level) {
        for (; n + 1 < model.levels[level].terms; ++n) {
            const T next = mul_add(factor, term, mul(weight, before));
            tail = mul_add(set<T>(inverse_factorials[n + 1]), next, tail);
            factor = sub(factor, epsilon);
            weight = add(weight, square);
            before = term;
            term = next;
        }
        if (level + 1 == model.levels.size()) break;
        const auto goes_on = less(set<T>(model.levels[level].growth), abs(growth));
        if (none(goes_on)) break;
        term = select(goes_on, term, set<T>(0));
        before = select(goes_on, before, set<T>(0));
    }
    return add(head, tail);
}

// (1 + ε)^n dⁿz/dεⁿ for n = 1, 2, 3, from z at ε.
template <class T>
struct Derivatives {
    T first, second, third;
};

template <class T>
HWY_INLINE Derivatives<T> derivatives(const Model& model, const Start<T>& from, T rest, T z) {
    const T x = mul(from.x, rest);
    const T sum = add(set<T>(model.a), x);
    Derivatives<T> result;
    result.first = mul_add(sum, z, neg_mul_add(x, from.reversal, from.drive));
    result.second = mul_add(sub(sum, set<T>(1)), result.first, mul(x, sub(z, from.reversal)));
    result.third = mul_add(sub(sum, set<T>(2)), result.second, mul(add(x, x), result.first));
    return result;
}

// Where the quintic with the values and two derivatives of z at both ends of the interval is 0, nearly, as a
// part of `left`.
template <class T>
HWY_INLINE T guess(const Model& model, const Start<T>& from, T left, T end_gap) {
    const T one = set<T>(1);
    const T zero = set<T>(0);
    const T half = set<T>(0.5);
    const Derivatives<T> begin = derivatives(model, from, one, from.gap);
    const T rest = add(one, left);
    const Derivatives<T> end = derivatives(model, from, rest, end_gap);
    const T scale = mul(left, rough_reciprocal(rest));
    // p(u) = Σ c_n uⁿ
    const T c0 = from.gap;
    const T c1 = mul(left, begin.first);
    const T c2 = mul(mul(half, mul(left, left)), begin.second);
    const T twice_c2 = add(c2, c2);
    const T value = sub(sub(end_gap, c0), add(c1, c2));
    const T slope = sub(mul(scale, end.first), add(c1, twice_c2));
    const T bend = mul_sub(mul(half, mul(scale, scale)), end.second, c2);
    const T c3 = mul_add(set<T>(10), value, neg_mul_add(set<T>(4), slope, bend));
    const T c4 = neg_mul_add(set<T>(15), value, mul_sub(set<T>(7), slope, add(bend, bend)));
    const T c5 = mul_add(set<T>(6), value, neg_mul_add(set<T>(3), slope, bend));
    const T s3 = mul(set<T>(3), c3);
    const T s4 = mul(set<T>(4), c4);
    const T s5 = mul(set<T>(5), c5);
    T u = clamp(mul(c0, rough_reciprocal(sub(c0, end_gap))), zero, one);
    for (int i = 0; i < 2; ++i) {
        const T p = mul_add(mul_add(mul_add(mul_add(mul_add(c5, u, c4), u, c3), u, c2), u, c1), u, c0);
        const T dp = mul_add(mul_add(mul_add(mul_add(s5, u, s4), u, s3), u, twice_c2), u, c1);
        u = clamp(neg_mul_add(p, rough_reciprocal(dp), u), zero, one);
    }
    return u;
}

template <class T>
struct Crossing {
    using Mask = decltype(less(T(), T()));
    T span;  // in units of tau_m
    T g;     // at it
    T left;  // after it
    Mask solved;
};

template <class T>
HWY_INLINE Crossing<T> solve_adapting(const Model& model, T reversal, T gap, T g, T excess, T end, T left) {
    const T one = set<T>(1);
    const T zero = set<T>(0);
    const T a = set<T>(model.a);
    const Start<T> begin{mul(a, g), gap, reversal, mul(a, excess)};
    const T u = guess(model, begin, left, end);
    // The series begins at the nearer end of the interval, where ε is `origin`: so it has fewer terms.
    const auto late = less(set<T>(0.5), u);
    const T origin = select(late, left, zero);
    const T kept = add(one, origin);
    const T per_kept = rough_reciprocal(kept);
    const Start<T> from{mul(begin.x, kept), select(late, end, gap), reversal, begin.drive};
    T epsilon = mul(neg_mul_add(origin, one, mul(u, left)), per_kept);
    T slope = zero;
    auto settled = less(one, zero);
    // The inverse of z around ε to third order: with q = −z/z′ and h_n = z⁽ⁿ⁾/(n! z′) the step is
    // q − h₂q² + (2h₂² − h₃)q³, and its relative error some 5 r³ where r = q √(h₂² + |h₃|). Usually the first
    // step has r² ≤ 1e-8 and settles the lane. A settled lane no longer changes, so that its result does not
    // depend on the other lanes.
    for (int i = 0; i < 4 && !all(settled); ++i) {
        const T z = flow(model, from, epsilon);
        const T rest = add(one, epsilon);
        const Derivatives<T> here = derivatives(model, from, rest, z);
        const T inverse = div(one, here.first);
        const T q = neg(mul(z, inverse));
        const T h2 = mul(mul(set<T>(0.5), here.second), inverse);
        const T h3 = mul(mul(set<T>(1.0 / 6), here.third), inverse);
        const T h2_squared = mul(h2, h2);
        const T q_squared = mul(q, q);
        const T bend = mul_sub(q, mul_sub(set<T>(2), h2_squared, h3), h2);
        const T step = mul_add(q_squared, bend, q);
        const T next = clamp(mul_add(rest, step, epsilon), left, neg(left));
        epsilon = select(settled, epsilon, next);
        slope = select(settled, slope, here.first);
        settled = either(settled, at_most(mul(q_squared, add(h2_squared, abs(h3))), set<T>(1e-8)));
    }
    epsilon = clamp(mul_add(kept, epsilon, origin), left, zero);
    const T rest = add(one, epsilon);
    const T twice = add(one, rest);
    const T inverse = div(one, mul(rest, twice));
    // log1p(ε) = 2 atanh(y), y = ε/(2 + ε)
    const T y = mul(mul(epsilon, rest), inverse);
    const T y_squared = mul(y, y);
    T sum = set<T>(model.log_terms[model.log_count - 1]);
    for (std::size_t n = model.log_count - 1; n > 0; --n)
        sum = mul_add(sum, y_squared, set<T>(model.log_terms[n - 1]));
    // Not solved: no spike after all, a root that has not settled, a grazing one.
    const T parts = add(add(abs(gap), abs(excess)), reversal);
    const auto steep = at_most(mul(set<T>(model.graze), parts), slope);
    return {mul(sum, y), mul(g, rest), clamp(mul(mul(sub(left, epsilon), twice), inverse), left, zero),
            both(at_most(end, zero), both(settled, steep))};
}

HWY_INLINE Crossing<V> solve_plain(const Item& item) {
    const V over = hn::Add(item.gap, item.excess);
    Crossing<V> result;
    result.span = hn::Log1p(d, hn::Div(item.gap, item.excess));
    result.g = hn::Zero(d);
    result.left = hn::Min(hn::Div(hn::Mul(item.left, over), item.excess), constant(1));
    result.solved = hn::Gt(item.excess, hn::Zero(d));
    return result;
}

// value(k) of so many vectors, as one T.
template <int vectors, int first = 0, class Value>
HWY_INLINE auto together(Value&& value) {
    if constexpr (vectors == 1)
        return value(first);
    else
        return Pair{together<vectors / 2, first>(value), together<vectors / 2, first + vectors / 2>(value)};
}

// use(k, value) for each vector of a T.
template <int first = 0, class T, class Use>
HWY_INLINE void apart(const T& value, Use&& use) {
    if constexpr (is_pair<T>) {
        constexpr int half = vectors_of<decltype(value.first)>;
        apart<first>(value.first, use);
        apart<first + half>(value.second, use);
    } else {
        use(first, value);
    }
}

// What the mathematics needs of the vectors of a batch.
template <int vectors>
HWY_INLINE void solve(const Model& model, const Element (&each)[vectors], const Item (&item)[vectors],
                      Crossing<V> (&found)[vectors]) {
    const auto all = solve_adapting(model, together<vectors>([&](int k) { return each[k].reversal; }),
                                    together<vectors>([&](int k) { return item[k].gap; }),
                                    together<vectors>([&](int k) { return item[k].g; }),
                                    together<vectors>([&](int k) { return item[k].excess; }),
                                    together<vectors>([&](int k) { return item[k].end; }),
                                    together<vectors>([&](int k) { return item[k].left; }));
    apart(all.span, [&](int k, V span) { found[k].span = span; });
    apart(all.g, [&](int k, V g) { found[k].g = g; });
    apart(all.left, [&](int k, V left) { found[k].left = left; });
    apart(all.solved, [&](int k, M solved) { found[k].solved = solved; });
}

// The gaps at the end of the step.
template <int vectors>
HWY_INLINE void flow_to_end(const Model& model, const Element (&each)[vectors], Item (&item)[vectors]) {
    const V a = constant(model.a);
    using T = decltype(together<vectors>([&](int k) { return item[k].gap; }));
    const Start<T> start{together<vectors>([&](int k) { return hn::Mul(a, item[k].g); }),
                         together<vectors>([&](int k) { return item[k].gap; }),
                         together<vectors>([&](int k) { return each[k].reversal; }),
                         together<vectors>([&](int k) { return hn::Mul(a, item[k].excess); })};
    apart(flow(model, start, together<vectors>([&](int k) { return item[k].left; })),
          [&](int k, V end) { item[k].end = end; });
}

// Advances the chosen neurons to the end of the step. Those that reach threshold again are appended to
// `crossing`, those whose g is beyond the series to `hard`; both are stored once more later, and so are those
// that are not chosen.
template <bool adapts, int vectors>
HWY_INLINE void go_on(const Model& model, const Neurons& neurons, const Element (&each)[vectors],
                      Item (&item)[vectors], const M (&chosen)[vectors], Batch& crossing, Batch& hard) {
    if constexpr (adapts) flow_to_end(model, each, item);
    for (int k = 0; k < vectors; ++k) {
        if constexpr (!adapts)
            item[k].end = hn::NegMulAdd(item[k].excess, hn::Sub(constant(1), item[k].left),
                                        hn::Mul(item[k].gap, item[k].left));
        hn::ScatterIndex(item[k].end, d, neurons.gap_mv, item[k].index);
        M goes = hn::AndNot(hn::Gt(item[k].end, hn::Zero(d)), chosen[k]);
        if constexpr (adapts) {
            const V end_g = hn::MulAdd(item[k].g, item[k].left, item[k].g);
            hn::ScatterIndex(hn::Mul(end_g, constant(1 / neurons.end_scale)), d, neurons.scaled_g,
                             item[k].index);
            const M beyond = hn::AndNot(hn::Le(item[k].g, constant(model.g_limit)), chosen[k]);
            if (HWY_UNLIKELY(!hn::AllFalse(d, beyond))) {
                append(model, item[k], beyond, hard);
                goes = hn::AndNot(beyond, goes);
            }
        }
        if (!hn::AllFalse(d, goes)) append(model, item[k], goes, crossing);
    }
}

// Several vectors of the crossings, from `at` on; what remains of them goes to `after`. Returns how many
// keys it has written.
template <bool adapts, bool rests, int vectors>
HWY_INLINE std::size_t fire_some(const Model& model, const Neurons& neurons, double start_ns, double end_ns,
                                 std::size_t at, const Batch& crossing, Batch& after, Batch& hard,
                                 std::uint64_t* keys, double* times_ns) {
    const std::size_t lanes = hn::Lanes(d);
    Item item[vectors];
    M solved[vectors];
    Element each[vectors];
    Crossing<V> found[vectors];
    for (int k = 0; k < vectors; ++k) {
        item[k] = load(crossing, at, at + k * lanes);
        each[k] = gathered(model, neurons, item[k].index);
    }
    if constexpr (adapts)
        solve(model, each, item, found);
    else
        for (int k = 0; k < vectors; ++k) found[k] = solve_plain(item[k]);
    std::size_t fired = 0;
    for (int k = 0; k < vectors; ++k) {
        const M real = lanes_in(crossing, at + k * lanes);
        solved[k] = hn::And(real, found[k].solved);
        const M unsolved = hn::AndNot(solved[k], real);
        if (HWY_UNLIKELY(!hn::AllFalse(d, unsolved))) append(model, item[k], unsolved, hard);

        item[k].elapsed = hn::Add(item[k].elapsed, found[k].span);
        const V time_ns = hn::MulAdd(item[k].elapsed, constant(model.tau_ns), constant(start_ns));
        const V stamp_ns = clamp(hn::Ceil(time_ns), constant(1), constant(end_ns));
        const VI key = hn::Or(hn::ShiftLeft<32>(hn::ConvertTo(di, stamp_ns)), item[k].index);
        const Packing packing(solved[k]);
        packing.put(key, reinterpret_cast<std::int64_t*>(keys + fired));
        if (times_ns != nullptr) packing.put(time_ns, times_ns + fired);
        fired += packing.count;

        item[k].gap = each[k].reset_gap;
        if constexpr (adapts) item[k].g = hn::Add(found[k].g, each[k].delta_g);
        item[k].left = found[k].left;
        if constexpr (rests) append(model, item[k], solved[k], after);
    }
    if constexpr (!rests) go_on<adapts>(model, neurons, each, item, solved, after, hard);
    return fired;
}

// Calls some(at, vectors) for the vectors of a batch: by groups, and the rest by two or by itself. Three take
// less time as a group.
template <class Some>
HWY_INLINE void for_each_vector(std::size_t size, Some&& some) {
    const std::size_t lanes = hn::Lanes(d);
    std::size_t at = 0;
    for (; at + 2 * lanes < size; at += group_vectors * lanes)
        some(at, std::integral_constant<int, group_vectors>());
    if (at + lanes < size)
        some(at, std::integral_constant<int, 2>());
    else if (at < size)
        some(at, std::integral_constant<int, 1>());
}

template <bool adapts, bool rests>
std::size_t fire(const Model& model, const Neurons& neurons, double start_ns, double end_ns,
                 const Batch& crossing, Batch& after, Batch& hard, std::uint64_t* keys, double* times_ns) {
    std::size_t fired = 0;
    for_each_vector(crossing.size, [&](std::size_t at, auto vectors) {
        fired +=
            fire_some<adapts, rests, vectors>(model, neurons, start_ns, end_ns, at, crossing, after, hard,
                                              keys + fired, times_ns == nullptr ? nullptr : times_ns + fired);
    });
    return fired;
}

template <bool adapts>
void finish(const Model& model, const Neurons& neurons, const Batch& batch, Batch& crossing, Batch& hard) {
    for_each_vector(batch.size, [&]<int vectors>(std::size_t at, std::integral_constant<int, vectors>) {
        Item item[vectors];
        Element each[vectors];
        M real[vectors];
        for (int k = 0; k < vectors; ++k) {
            const std::size_t here = at + static_cast<std::size_t>(k) * hn::Lanes(d);
            item[k] = load(batch, at, here);
            each[k] = gathered(model, neurons, item[k].index);
            real[k] = lanes_in(batch, here);
        }
        go_on<adapts>(model, neurons, each, item, real, crossing, hard);
    });
}

// ---------------------------------------------------------------------------------------------------------------------

template <int near_count>
void sweep_with(const Model& model, const Neurons& neurons, const double* drives_mv, std::size_t begin,
                std::size_t count, Batch& crossing, Batch& hard) {
    (neurons.v_th_mv == nullptr
         ? &sweep<near_count, false>
         : &sweep<near_count, true>)(model, neurons, drives_mv, begin, count, crossing, hard);
}

void sweep_any(const Model& model, const Neurons& neurons, const double* drives_mv, std::size_t begin,
               std::size_t count, Batch& crossing, Batch& hard) {
    const auto chosen = !model.adapts                        ? &sweep_with<0>
                        : model.near.count == near_counts[0] ? &sweep_with<near_counts[0]>
                        : model.near.count == near_counts[1] ? &sweep_with<near_counts[1]>
                                                             : &sweep_with<near_counts[2]>;
    chosen(model, neurons, drives_mv, begin, count, crossing, hard);
}

std::size_t fire_any(const Model& model, const Neurons& neurons, double start_ns, double end_ns,
                     const Batch& crossing, Batch& after, Batch& hard, std::uint64_t* keys,
                     double* times_ns) {
    const auto chosen = model.adapts   ? neurons.rest ? &fire<true, true> : &fire<true, false>
                          : neurons.rest ? &fire<false, true>
                                       : &fire<false, false>;
    return chosen(model, neurons, start_ns, end_ns, crossing, after, hard, keys, times_ns);
}

void finish_any(const Model& model, const Neurons& neurons, const Batch& batch, Batch& crossing,
                Batch& hard) {
    (model.adapts ? &finish<true> : &finish<false>)(model, neurons, batch, crossing, hard);
}

}  // namespace

void describe(Kernel& kernel) {
    kernel = {&sweep_any,
              &fire_any,
              &finish_any,
              hn::Lanes(d),
              group_vectors * hn::Lanes(d),
              hwy::TargetName(HWY_TARGET)};
}

}  // namespace afferent::dense::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afferent::dense {

HWY_EXPORT(describe);

Kernel kernel() {
    Kernel result;
    HWY_DYNAMIC_DISPATCH(describe)(result);
    return result;
}

}  // namespace afferent::dense
#endif
