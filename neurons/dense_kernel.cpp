#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "afferent/neurons/dense_kernel.cpp"
#include <hwy/foreach_target.h>  // includes this file once for every instruction set
#include <hwy/highway.h>
// Must follow highway.h.
#include <hwy/contrib/math/math-inl.h>

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

HWY_INLINE Element common_element(const Model& model) {
    return element(model, constant(model.v_th_mv), constant(model.delta_g));
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

struct Item {
    V gap, g, excess, left, elapsed;
    VI index;
};

HWY_INLINE Item load(const Batch& batch, std::size_t at) {
    return {hn::Load(d, batch.gap_mv.data() + at),    hn::Load(d, batch.g.data() + at),
            hn::Load(d, batch.excess_mv.data() + at), hn::Load(d, batch.left.data() + at),
            hn::Load(d, batch.elapsed.data() + at),   hn::Load(di, batch.index.data() + at)};
}

HWY_INLINE void append(const Model& model, const Item& item, M mask, Batch& batch) {
    const std::size_t at = batch.size;
    const Packing packing(mask);
    packing.put(item.gap, batch.gap_mv.data() + at);
    if (model.adapts) packing.put(item.g, batch.g.data() + at);
    packing.put(item.excess, batch.excess_mv.data() + at);
    packing.put(item.left, batch.left.data() + at);
    packing.put(item.elapsed, batch.elapsed.data() + at);
    packing.put(item.index, batch.index.data() + at);
    batch.size += packing.count;
}

HWY_INLINE Element gathered(const Model& model, const Neurons& neurons, VI index) {
    if (!model.individual) return common_element(model);
    return element(model, hn::GatherIndex(d, neurons.v_th_mv, index),
                   model.adapts ? hn::GatherIndex(d, neurons.delta_g, index) : hn::Zero(d));
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

template <bool adapts, bool individual>
void sweep(const Model& model, const Neurons& neurons, const double* drives_mv, std::size_t begin,
           std::size_t count, Batch& crossing) {
    const std::size_t lanes = hn::Lanes(d);
    const IntervalPolynomials& fit = model.polynomials;
    const V u_scale = constant(2 / fit.g_max);
    const V g_max = constant(fit.g_max);
    const V kept = constant(1 + model.fall);
    Element each = common_element(model);
    std::size_t found = crossing.size;
    for (std::size_t i = 0; i < count; i += lanes) {
        const std::size_t at = begin + i;
        const V gap = hn::Load(d, neurons.gap_mv + at);
        if constexpr (individual)
            each = element(model, hn::Load(d, neurons.v_th_mv + at),
                           adapts ? hn::Load(d, neurons.delta_g + at) : hn::Zero(d));
        const V over = excess(each, hn::LoadU(d, drives_mv + i));
        V g = hn::Zero(d);
        V end;
        M stays;
        if constexpr (adapts) {
            g = hn::Load(d, neurons.g + at);
            const V u = hn::MulSub(g, u_scale, constant(1));
            const V u_squared = hn::Mul(u, u);
            const V phi = polynomial(fit.phi.data(), fit.count, u, u_squared);
            const V chi = hn::Mul(g, polynomial(fit.chi.data(), fit.count, u, u_squared));
            const V psi = hn::Sub(hn::Sub(constant(1), phi), chi);
            end = hn::NegMulAdd(over, psi, hn::MulAdd(each.reversal, chi, hn::Mul(gap, phi)));
            stays = hn::And(hn::Gt(end, hn::Zero(d)), hn::Le(g, g_max));
        } else {
            end = hn::NegMulAdd(over, constant(1 - model.decay), hn::Mul(gap, constant(model.decay)));
            stays = hn::Gt(end, hn::Zero(d));
        }
        // Neurons that cross are stored later, from their batch.
        hn::Store(hn::IfThenElse(stays, end, gap), d, neurons.gap_mv + at);
        if constexpr (adapts) hn::Store(hn::IfThenElse(stays, hn::Mul(g, kept), g), d, neurons.g + at);
        // No branch: whether a vector has a crossing is random and would be mispredicted.
        const Packing goes(hn::Not(stays));
        goes.put(gap, crossing.gap_mv.data() + found);
        if constexpr (adapts) goes.put(g, crossing.g.data() + found);
        goes.put(over, crossing.excess_mv.data() + found);
        goes.put(hn::Iota(di, static_cast<std::int64_t>(at)), crossing.index.data() + found);
        found += goes.count;
    }
    for (std::size_t i = crossing.size; i < found; i += lanes) {
        hn::StoreU(constant(adapts ? model.fall : model.decay), d, crossing.left.data() + i);
        hn::StoreU(hn::Zero(d), d, crossing.elapsed.data() + i);
    }
    crossing.size = found;
}

// ---------------------------------------------------------------------------------------------------------------------

// The functions below take `vectors` of a batch at once: the chains of one vector's operations are long, and
// a second one fills the gaps.

// The series of ShortInterval over the rest of the step. `end` is its sum, which is z at the end.
template <int vectors>
HWY_INLINE void series(const Model& model, const Element (&each)[vectors], const Item (&item)[vectors],
                       double* HWY_RESTRICT terms, V (&end)[vectors]) {
    const std::size_t lanes = hn::Lanes(d);
    const V a = constant(model.a);
    V square[vectors], factor[vectors], before[vectors], term[vectors], sum[vectors], other_sum[vectors];
    for (int k = 0; k < vectors; ++k) {
        const V x = hn::Mul(a, item[k].g);
        const V pull = hn::Mul(item[k].left, hn::Mul(x, each[k].reversal));
        const V push = hn::Mul(item[k].left, hn::Mul(a, item[k].excess));
        square[k] = hn::Mul(hn::Mul(item[k].left, item[k].left), x);
        const V growth = hn::Mul(item[k].left, hn::Add(a, x));
        const V first = item[k].gap;
        const V second = hn::MulAdd(growth, first, hn::Sub(push, pull));
        const V third =
            hn::Mul(constant(0.5), hn::MulAdd(hn::Sub(growth, item[k].left), second,
                                              hn::Mul(square[k], hn::Sub(first, each[k].reversal))));
        hn::Store(first, d, terms + k * lanes);
        hn::Store(second, d, terms + (vectors + k) * lanes);
        hn::Store(third, d, terms + (2 * vectors + k) * lanes);
        sum[k] = hn::Add(first, second);
        other_sum[k] = third;
        before[k] = second;
        term[k] = third;
        factor[k] = hn::NegMulAdd(constant(2), item[k].left, growth);
    }
    for (std::size_t n = 2; n + 1 < model.terms; ++n) {
        const V share = constant(1 / static_cast<double>(n + 1));
        for (int k = 0; k < vectors; ++k) {
            const V next =
                hn::MulAdd(hn::Mul(share, factor[k]), term[k], hn::Mul(hn::Mul(share, square[k]), before[k]));
            hn::Store(next, d, terms + ((n + 1) * vectors + k) * lanes);
            factor[k] = hn::Sub(factor[k], item[k].left);
            const V swap = sum[k];
            sum[k] = hn::Add(other_sum[k], next);
            other_sum[k] = swap;
            before[k] = term[k];
            term[k] = next;
        }
    }
    for (int k = 0; k < vectors; ++k) end[k] = hn::Add(sum[k], other_sum[k]);
}

template <int vectors>
HWY_INLINE void series_at(const Model& model, const double* HWY_RESTRICT terms, const V (&part)[vectors],
                          V (&z)[vectors]) {
    const std::size_t lanes = hn::Lanes(d);
    V square[vectors], even[vectors], odd[vectors];
    const auto load = [&](std::size_t n, int k) { return hn::Load(d, terms + (n * vectors + k) * lanes); };
    for (int k = 0; k < vectors; ++k) {
        square[k] = hn::Mul(part[k], part[k]);
        even[k] = load(model.terms - 2, k);
        odd[k] = load(model.terms - 1, k);
    }
    for (std::size_t n = model.terms - 2; n > 0; n -= 2)
        for (int k = 0; k < vectors; ++k) {
            even[k] = hn::MulAdd(even[k], square[k], load(n - 2, k));
            odd[k] = hn::MulAdd(odd[k], square[k], load(n - 1, k));
        }
    for (int k = 0; k < vectors; ++k) z[k] = hn::MulAdd(odd[k], part[k], even[k]);
}

struct Crossing {
    V span;  // in units of tau_m
    V g;     // at it
    V left;  // after it
    M solved;
};

template <int vectors>
HWY_INLINE void solve_adapting(const Model& model, const Element (&each)[vectors],
                               const Item (&item)[vectors], Crossing (&result)[vectors]) {
    HWY_ALIGN double terms[max_terms * max_lanes * vectors];
    const V one = constant(1);
    const V zero = hn::Zero(d);
    const V a = constant(model.a);
    V end[vectors];
    series(model, each, item, terms, end);

    V x[vectors], drive[vectors], per_left[vectors], epsilon[vectors], slope[vectors], z[vectors],
        part[vectors];
    M settled[vectors];
    for (int k = 0; k < vectors; ++k) {
        x[k] = hn::Mul(a, item[k].g);
        drive[k] = hn::Mul(a, item[k].excess);
        // First guess: the parabola through both ends with the slope that the equation gives at the second.
        const V x_end = hn::MulAdd(x[k], item[k].left, x[k]);
        const V slope_end = hn::Div(
            hn::Mul(item[k].left,
                    hn::MulAdd(hn::Add(a, x_end), end[k], hn::NegMulAdd(x_end, each[k].reversal, drive[k]))),
            hn::Add(one, item[k].left));
        const V bend = hn::Add(hn::Sub(item[k].gap, end[k]), slope_end);
        // In r, measured backwards from the end: end − slope·r + bend·r² = 0.
        const V inner =
            hn::Max(hn::NegMulAdd(hn::Mul(constant(4), bend), end[k], hn::Mul(slope_end, slope_end)), zero);
        const V back = hn::Div(hn::Mul(constant(-2), end[k]), hn::Sub(hn::Sqrt(inner), slope_end));
        const V guess = hn::Sub(one, hn::Min(hn::Max(back, zero), one));
        per_left[k] = hn::Div(one, item[k].left);
        epsilon[k] = hn::Mul(guess, item[k].left);
        slope[k] = zero;
        settled[k] = hn::FirstN(d, 0);
    }

    // Halley's steps in ε; the equation gives both derivatives of z. A step triples the digits, so that one
    // below 1e-5 of the interval is the last. A lane that has made it stays as it is: its result does not
    // depend on the others.
    bool all_settled = false;
    for (int i = 0; i < 3 && !all_settled; ++i) {
        for (int k = 0; k < vectors; ++k) part[k] = hn::Mul(epsilon[k], per_left[k]);
        series_at(model, terms, part, z);
        all_settled = true;
        for (int k = 0; k < vectors; ++k) {
            const V rest = hn::Add(one, epsilon[k]);
            const V x_here = hn::Mul(x[k], rest);
            const V sum = hn::Add(a, x_here);
            const V slope_here = hn::MulAdd(sum, z[k], hn::NegMulAdd(x_here, each[k].reversal, drive[k]));
            const V curvature = hn::MulAdd(hn::Sub(sum, one), slope_here,
                                           hn::Mul(hn::Mul(x[k], rest), hn::Sub(z[k], each[k].reversal)));
            const V twice = hn::Add(z[k], z[k]);
            const V step =
                hn::Div(hn::Mul(hn::Mul(twice, slope_here), rest),
                        hn::NegMulAdd(z[k], curvature, hn::Mul(hn::Add(slope_here, slope_here), slope_here)));
            const V next = hn::Min(hn::Max(hn::Sub(epsilon[k], step), item[k].left), zero);
            epsilon[k] = hn::IfThenElse(settled[k], epsilon[k], next);
            slope[k] = hn::IfThenElse(settled[k], slope[k], slope_here);
            settled[k] = hn::Or(settled[k], hn::Le(hn::Abs(step), hn::Mul(constant(-1e-5), item[k].left)));
            all_settled = all_settled && hn::AllTrue(d, settled[k]);
        }
    }
    for (int k = 0; k < vectors; ++k) {
        const V rest = hn::Add(one, epsilon[k]);
        result[k].span = hn::Neg(hn::Mul(a, hn::Log1p(d, epsilon[k])));
        result[k].g = hn::Mul(item[k].g, rest);
        result[k].left = hn::Min(hn::Div(hn::Sub(item[k].left, epsilon[k]), rest), zero);
        // Not solved: g beyond the series, no spike after all, a root that has not settled, a grazing one.
        const V parts = hn::Add(hn::Add(hn::Abs(item[k].gap), hn::Abs(item[k].excess)), each[k].reversal);
        const M steep = hn::Ge(slope[k], hn::Mul(constant(model.graze), parts));
        result[k].solved = hn::And(hn::And(hn::Le(item[k].g, constant(model.g_limit)), hn::Le(end[k], zero)),
                                   hn::And(settled[k], steep));
    }
}

HWY_INLINE Crossing solve_plain(const Item& item) {
    const V over = hn::Add(item.gap, item.excess);
    Crossing result;
    result.span = hn::Log1p(d, hn::Div(item.gap, item.excess));
    result.g = hn::Zero(d);
    result.left = hn::Min(hn::Div(hn::Mul(item.left, over), item.excess), constant(1));
    result.solved = hn::Gt(item.excess, hn::Zero(d));
    return result;
}

// The crossings from `at` on, as many vectors of them. Returns how many keys it has written.
template <bool adapts, int vectors>
HWY_INLINE std::size_t fire_some(const Model& model, const Neurons& neurons, double start_ns, double end_ns,
                                 std::size_t at, std::size_t size, Batch& crossing, Batch& hard,
                                 std::uint64_t* keys, double* times_ns) {
    const std::size_t lanes = hn::Lanes(d);
    Item item[vectors];
    M real[vectors];
    Element each[vectors];
    Crossing found[vectors];
    for (int k = 0; k < vectors; ++k) {
        const std::size_t here = at + k * lanes;
        item[k] = load(crossing, here);
        real[k] = hn::FirstN(d, size - here);
        // The lanes beyond the batch hold arbitrary values; as indices they must be valid.
        if (size - here < lanes)
            item[k].index = hn::IfThenElseZero(hn::RebindMask(di, real[k]), item[k].index);
        each[k] = gathered(model, neurons, item[k].index);
    }
    if constexpr (adapts)
        solve_adapting(model, each, item, found);
    else
        for (int k = 0; k < vectors; ++k) found[k] = solve_plain(item[k]);
    std::size_t fired = 0;
    for (int k = 0; k < vectors; ++k) {
        const M solved = hn::And(real[k], found[k].solved);
        const M unsolved = hn::AndNot(solved, real[k]);
        if (!hn::AllFalse(d, unsolved)) append(model, item[k], unsolved, hard);

        item[k].elapsed = hn::Add(item[k].elapsed, found[k].span);
        const V time_ns = hn::MulAdd(item[k].elapsed, constant(model.tau_ns), constant(start_ns));
        const V stamp_ns = hn::Max(hn::Min(hn::Ceil(time_ns), constant(end_ns)), constant(1));
        const VI key = hn::Or(hn::ShiftLeft<32>(hn::ConvertTo(di, stamp_ns)), item[k].index);
        const Packing packing(solved);
        packing.put(key, reinterpret_cast<std::int64_t*>(keys + fired));
        if (times_ns != nullptr) packing.put(time_ns, times_ns + fired);
        fired += packing.count;

        item[k].gap = each[k].reset_gap;
        if constexpr (adapts) item[k].g = hn::Add(found[k].g, each[k].delta_g);
        item[k].left = found[k].left;
        append(model, item[k], solved, crossing);
    }
    return fired;
}

template <bool adapts>
std::size_t fire(const Model& model, const Neurons& neurons, double start_ns, double end_ns, Batch& crossing,
                 Batch& hard, std::uint64_t* keys, double* times_ns) {
    const std::size_t lanes = hn::Lanes(d);
    const std::size_t size = crossing.size;
    std::size_t fired = 0;
    std::size_t at = 0;
    const auto times = [&] { return times_ns == nullptr ? nullptr : times_ns + fired; };
    crossing.size = 0;
    for (; at + lanes < size; at += 2 * lanes)
        fired += fire_some<adapts, 2>(model, neurons, start_ns, end_ns, at, size, crossing, hard,
                                      keys + fired, times());
    if (at < size)
        fired += fire_some<adapts, 1>(model, neurons, start_ns, end_ns, at, size, crossing, hard,
                                      keys + fired, times());
    return fired;
}

template <bool adapts, int vectors>
HWY_INLINE void finish_some(const Model& model, const Neurons& neurons, std::size_t at, std::size_t size,
                            Batch& batch) {
    const std::size_t lanes = hn::Lanes(d);
    Item item[vectors];
    M real[vectors];
    V end[vectors];
    for (int k = 0; k < vectors; ++k) {
        const std::size_t here = at + k * lanes;
        item[k] = load(batch, here);
        real[k] = hn::FirstN(d, size - here);
        // Lanes beyond the batch repeat its first item: storing that twice does no harm.
        if (size - here < lanes) {
            const auto first = [&](V values, double value) {
                return hn::IfThenElse(real[k], values, constant(value));
            };
            item[k].gap = first(item[k].gap, hn::GetLane(item[k].gap));
            item[k].g = first(item[k].g, hn::GetLane(item[k].g));
            item[k].excess = first(item[k].excess, hn::GetLane(item[k].excess));
            item[k].left = first(item[k].left, hn::GetLane(item[k].left));
            item[k].index = hn::IfThenElse(hn::RebindMask(di, real[k]), item[k].index,
                                           hn::Set(di, hn::GetLane(item[k].index)));
        }
    }
    if constexpr (adapts) {
        HWY_ALIGN double terms[max_terms * max_lanes * vectors];
        Element each[vectors];
        for (int k = 0; k < vectors; ++k) each[k] = gathered(model, neurons, item[k].index);
        series(model, each, item, terms, end);
    }
    for (int k = 0; k < vectors; ++k) {
        M stays;
        if constexpr (adapts) {
            stays = hn::And(hn::Gt(end[k], hn::Zero(d)), hn::Le(item[k].g, constant(model.g_limit)));
        } else {
            end[k] = hn::NegMulAdd(item[k].excess, hn::Sub(constant(1), item[k].left),
                                   hn::Mul(item[k].gap, item[k].left));
            stays = hn::Gt(end[k], hn::Zero(d));
        }
        // Neurons that fire again are stored once more after their last spike.
        hn::ScatterIndex(end[k], d, neurons.gap_mv, item[k].index);
        if constexpr (adapts)
            hn::ScatterIndex(hn::MulAdd(item[k].g, item[k].left, item[k].g), d, neurons.g, item[k].index);
        const M goes = hn::AndNot(stays, real[k]);
        if (!hn::AllFalse(d, goes)) append(model, item[k], goes, batch);
    }
}

template <bool adapts>
void finish(const Model& model, const Neurons& neurons, Batch& batch) {
    const std::size_t lanes = hn::Lanes(d);
    const std::size_t size = batch.size;
    std::size_t at = 0;
    batch.size = 0;
    for (; at + lanes < size; at += 2 * lanes) finish_some<adapts, 2>(model, neurons, at, size, batch);
    if (at < size) finish_some<adapts, 1>(model, neurons, at, size, batch);
}

// ---------------------------------------------------------------------------------------------------------------------

void sweep_any(const Model& model, const Neurons& neurons, const double* drives_mv, std::size_t begin,
               std::size_t count, Batch& crossing) {
    if (model.adapts)
        model.individual ? sweep<true, true>(model, neurons, drives_mv, begin, count, crossing)
                         : sweep<true, false>(model, neurons, drives_mv, begin, count, crossing);
    else
        model.individual ? sweep<false, true>(model, neurons, drives_mv, begin, count, crossing)
                         : sweep<false, false>(model, neurons, drives_mv, begin, count, crossing);
}

std::size_t fire_any(const Model& model, const Neurons& neurons, double start_ns, double end_ns,
                     Batch& crossing, Batch& hard, std::uint64_t* keys, double* times_ns) {
    return model.adapts ? fire<true>(model, neurons, start_ns, end_ns, crossing, hard, keys, times_ns)
                        : fire<false>(model, neurons, start_ns, end_ns, crossing, hard, keys, times_ns);
}

void finish_any(const Model& model, const Neurons& neurons, Batch& batch) {
    model.adapts ? finish<true>(model, neurons, batch) : finish<false>(model, neurons, batch);
}

}  // namespace

void describe(Kernel& kernel) {
    kernel = {&sweep_any, &fire_any, &finish_any, hn::Lanes(d), hwy::TargetName(HWY_TARGET)};
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
