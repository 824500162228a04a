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

// The series of ShortInterval over the rest of the step. Returns its sum, which is z at the end.
HWY_INLINE V series(const Model& model, const Element& each, const Item& item, double* HWY_RESTRICT terms) {
    const std::size_t lanes = hn::Lanes(d);
    const V a = constant(model.a);
    const V x = hn::Mul(a, item.g);
    const V pull = hn::Mul(item.left, hn::Mul(x, each.reversal));
    const V push = hn::Mul(item.left, hn::Mul(a, item.excess));
    const V square = hn::Mul(hn::Mul(item.left, item.left), x);
    const V growth = hn::Mul(item.left, hn::Add(a, x));
    V before = item.gap;
    V term = hn::MulAdd(growth, item.gap, hn::Sub(push, pull));
    hn::Store(before, d, terms);
    hn::Store(term, d, terms + lanes);
    V next = hn::Mul(constant(0.5), hn::MulAdd(hn::Sub(growth, item.left), term,
                                               hn::Mul(square, hn::Sub(item.gap, each.reversal))));
    hn::Store(next, d, terms + 2 * lanes);
    V sum = hn::Add(before, term);
    V other_sum = next;
    before = term;
    term = next;
    V factor = hn::NegMulAdd(constant(2), item.left, growth);
    for (std::size_t n = 2; n + 1 < model.terms; ++n) {
        const V share = constant(1 / static_cast<double>(n + 1));
        next = hn::MulAdd(hn::Mul(share, factor), term, hn::Mul(hn::Mul(share, square), before));
        hn::Store(next, d, terms + (n + 1) * lanes);
        factor = hn::Sub(factor, item.left);
        const V swap = sum;
        sum = hn::Add(other_sum, next);
        other_sum = swap;
        before = term;
        term = next;
    }
    return hn::Add(sum, other_sum);
}

HWY_INLINE V series_at(const Model& model, const double* HWY_RESTRICT terms, V part) {
    const std::size_t lanes = hn::Lanes(d);
    const V square = hn::Mul(part, part);
    V even = hn::Load(d, terms + (model.terms - 2) * lanes);
    V odd = hn::Load(d, terms + (model.terms - 1) * lanes);
    for (std::size_t n = model.terms - 2; n > 0; n -= 2) {
        even = hn::MulAdd(even, square, hn::Load(d, terms + (n - 2) * lanes));
        odd = hn::MulAdd(odd, square, hn::Load(d, terms + (n - 1) * lanes));
    }
    return hn::MulAdd(odd, part, even);
}

struct Crossing {
    V span;  // in units of tau_m
    V g;     // at it
    V left;  // after it
    M solved;
};

HWY_INLINE Crossing solve_adapting(const Model& model, const Element& each, const Item& item) {
    HWY_ALIGN double terms[max_terms * max_lanes];
    const V one = constant(1);
    const V zero = hn::Zero(d);
    const V end = series(model, each, item, terms);
    const V a = constant(model.a);
    const V x = hn::Mul(a, item.g);
    const V drive = hn::Mul(a, item.excess);

    // First guess: the parabola through both ends with the slope that the equation gives at the second.
    const V x_end = hn::MulAdd(x, item.left, x);
    const V slope_end = hn::Div(
        hn::Mul(item.left, hn::MulAdd(hn::Add(a, x_end), end, hn::NegMulAdd(x_end, each.reversal, drive))),
        hn::Add(one, item.left));
    const V bend = hn::Add(hn::Sub(item.gap, end), slope_end);
    // In r, measured backwards from the end: end − slope·r + bend·r² = 0.
    const V inner =
        hn::Max(hn::NegMulAdd(hn::Mul(constant(4), bend), end, hn::Mul(slope_end, slope_end)), zero);
    const V back = hn::Div(hn::Mul(constant(-2), end), hn::Sub(hn::Sqrt(inner), slope_end));
    V part = hn::Sub(one, hn::Min(hn::Max(back, zero), one));

    // Halley's steps in ε; the equation gives both derivatives of z.
    const V per_left = hn::Div(one, item.left);
    V epsilon = hn::Mul(part, item.left);
    V step = zero;
    V slope = zero;
    for (int i = 0; i < 3; ++i) {
        const V z = series_at(model, terms, hn::Mul(epsilon, per_left));
        const V rest = hn::Add(one, epsilon);
        const V x_here = hn::Mul(x, rest);
        const V sum = hn::Add(a, x_here);
        slope = hn::MulAdd(sum, z, hn::NegMulAdd(x_here, each.reversal, drive));
        const V curvature =
            hn::MulAdd(hn::Sub(sum, one), slope, hn::Mul(hn::Mul(x, rest), hn::Sub(z, each.reversal)));
        const V twice = hn::Add(z, z);
        step = hn::Div(hn::Mul(hn::Mul(twice, slope), rest),
                       hn::NegMulAdd(z, curvature, hn::Mul(hn::Add(slope, slope), slope)));
        epsilon = hn::Min(hn::Max(hn::Sub(epsilon, step), item.left), zero);
    }
    Crossing result;
    const V rest = hn::Add(one, epsilon);
    result.span = hn::Neg(hn::Mul(a, hn::Log1p(d, epsilon)));
    result.g = hn::Mul(item.g, rest);
    result.left = hn::Min(hn::Div(hn::Sub(item.left, epsilon), rest), zero);
    // Not solved: g beyond the series, no spike after all, a root that has not settled, a grazing one.
    const V parts = hn::Add(hn::Add(hn::Abs(item.gap), hn::Abs(item.excess)), each.reversal);
    const M settled = hn::Le(hn::Abs(step), hn::Mul(constant(-1e-5), item.left));
    const M steep = hn::Ge(slope, hn::Mul(constant(model.graze), parts));
    result.solved =
        hn::And(hn::And(hn::Le(item.g, constant(model.g_limit)), hn::Le(end, zero)), hn::And(settled, steep));
    return result;
}

HWY_INLINE Crossing solve_plain(const Model&, const Element&, const Item& item) {
    const V over = hn::Add(item.gap, item.excess);
    Crossing result;
    result.span = hn::Log1p(d, hn::Div(item.gap, item.excess));
    result.g = hn::Zero(d);
    result.left = hn::Min(hn::Div(hn::Mul(item.left, over), item.excess), constant(1));
    result.solved = hn::Gt(item.excess, hn::Zero(d));
    return result;
}

template <bool adapts>
std::size_t fire(const Model& model, const Neurons& neurons, double start_ns, double end_ns, Batch& crossing,
                 Batch& hard, std::uint64_t* keys, double* times_ns) {
    const std::size_t lanes = hn::Lanes(d);
    const std::size_t size = crossing.size;
    std::size_t fired = 0;
    crossing.size = 0;
    for (std::size_t at = 0; at < size; at += lanes) {
        Item item = load(crossing, at);
        const M real = hn::FirstN(d, size - at);
        if (size - at < lanes) {
            // The lanes beyond the batch hold arbitrary values; as indices they must be valid.
            item.index = hn::IfThenElseZero(hn::RebindMask(di, real), item.index);
        }
        const Element each = gathered(model, neurons, item.index);
        const Crossing found = adapts ? solve_adapting(model, each, item) : solve_plain(model, each, item);
        const M solved = hn::And(real, found.solved);
        const M unsolved = hn::AndNot(solved, real);
        if (!hn::AllFalse(d, unsolved)) append(model, item, unsolved, hard);

        item.elapsed = hn::Add(item.elapsed, found.span);
        const V time_ns = hn::MulAdd(item.elapsed, constant(model.tau_ns), constant(start_ns));
        const V stamp_ns = hn::Max(hn::Min(hn::Ceil(time_ns), constant(end_ns)), constant(1));
        const VI key = hn::Or(hn::ShiftLeft<32>(hn::ConvertTo(di, stamp_ns)), item.index);
        const Packing packing(solved);
        packing.put(key, reinterpret_cast<std::int64_t*>(keys + fired));
        if (times_ns != nullptr) packing.put(time_ns, times_ns + fired);
        fired += packing.count;

        item.gap = each.reset_gap;
        if constexpr (adapts) item.g = hn::Add(found.g, each.delta_g);
        item.left = found.left;
        append(model, item, solved, crossing);
    }
    return fired;
}

template <bool adapts>
void finish(const Model& model, const Neurons& neurons, Batch& batch) {
    const std::size_t lanes = hn::Lanes(d);
    const std::size_t size = batch.size;
    batch.size = 0;
    for (std::size_t at = 0; at < size; at += lanes) {
        Item item = load(batch, at);
        const M real = hn::FirstN(d, size - at);
        // Lanes beyond the batch repeat its first item: storing that twice does no harm.
        if (size - at < lanes) {
            const auto first = [&](V values, double value) {
                return hn::IfThenElse(real, values, constant(value));
            };
            item.gap = first(item.gap, hn::GetLane(item.gap));
            item.g = first(item.g, hn::GetLane(item.g));
            item.excess = first(item.excess, hn::GetLane(item.excess));
            item.left = first(item.left, hn::GetLane(item.left));
            item.index =
                hn::IfThenElse(hn::RebindMask(di, real), item.index, hn::Set(di, hn::GetLane(item.index)));
        }
        V end;
        V g_end = hn::Zero(d);
        M stays;
        if constexpr (adapts) {
            HWY_ALIGN double terms[max_terms * max_lanes];
            end = series(model, gathered(model, neurons, item.index), item, terms);
            g_end = hn::MulAdd(item.g, item.left, item.g);
            stays = hn::And(hn::Gt(end, hn::Zero(d)), hn::Le(item.g, constant(model.g_limit)));
        } else {
            end = hn::NegMulAdd(item.excess, hn::Sub(constant(1), item.left), hn::Mul(item.gap, item.left));
            stays = hn::Gt(end, hn::Zero(d));
        }
        // Neurons that fire again are stored once more after their last spike.
        hn::ScatterIndex(end, d, neurons.gap_mv, item.index);
        if constexpr (adapts) hn::ScatterIndex(g_end, d, neurons.g, item.index);
        const M goes = hn::AndNot(stays, real);
        if (!hn::AllFalse(d, goes)) append(model, item, goes, batch);
    }
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
