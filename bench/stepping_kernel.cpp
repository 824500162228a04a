#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/stepping_kernel.cpp"
#include <hwy/foreach_target.h>  // includes this file once for every instruction set
#include <hwy/highway.h>
// Must follow highway.h.
#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "bench/stepping_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace afferent::bench::stepping::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
template <class Real>
using D = hn::ScalableTag<Real>;
template <class Real>
using V = hn::Vec<D<Real>>;

// The constants of a step, or of a part of one that differs from lane to lane.
template <class Real>
struct Span {
    V<Real> step, decay, half_decay, fall;
};

template <class Real>
HWY_INLINE V<Real> all(Real value) {
    return hn::Set(D<Real>(), value);
}

template <Method method, class Real>
HWY_INLINE Span<Real> part(const Constants<Real>& c, V<Real> length) {
    const D<Real> d;
    Span<Real> span{length, length, length, length};
    if constexpr (method == Method::euler) {
        span.fall = hn::NegMulAdd(length, all(c.inverse_a), all(Real(1)));
    } else {
        span.half_decay = hn::Exp(d, hn::Mul(length, all(Real(-0.5) * c.inverse_a)));
        span.decay = hn::Mul(span.half_decay, span.half_decay);
    }
    return span;
}

template <Method method, class Real>
HWY_INLINE void advance(const Span<Real>& s, V<Real> b, V<Real>& w, V<Real>& g) {
    const D<Real> d;
    const V<Real> one = all(Real(1));
    const V<Real> rate = hn::Add(one, g);
    if constexpr (method == Method::euler) {
        w = hn::MulAdd(s.step, hn::NegMulAdd(rate, w, b), w);
        g = hn::Mul(g, s.fall);
    } else if constexpr (method == Method::exponential_euler) {
        const V<Real> target = hn::Div(b, rate);
        w = hn::MulAdd(hn::Sub(w, target), hn::Exp(d, hn::Neg(hn::Mul(rate, s.step))), target);
        g = hn::Mul(g, s.decay);
    } else {
        const V<Real> half = hn::Mul(all(Real(0.5)), s.step);
        const V<Real> sixth = hn::Mul(all(Real(1) / 6), s.step);
        const V<Real> half_rate = hn::MulAdd(g, s.half_decay, one);
        g = hn::Mul(g, s.decay);
        const V<Real> k1 = hn::NegMulAdd(rate, w, b);
        const V<Real> k2 = hn::NegMulAdd(half_rate, hn::MulAdd(half, k1, w), b);
        const V<Real> k3 = hn::NegMulAdd(half_rate, hn::MulAdd(half, k2, w), b);
        const V<Real> k4 = hn::NegMulAdd(hn::Add(one, g), hn::MulAdd(s.step, k3, w), b);
        w = hn::MulAdd(sixth, hn::MulAdd(all(Real(2)), hn::Add(k2, k3), hn::Add(k1, k4)), w);
    }
}

template <class Real>
void set_drives(const double* drives_mv, double offset_mv, std::size_t size, Tile<Real>& tile) {
    for (std::size_t i = 0; i < size; ++i) tile.b[i] = static_cast<Real>(drives_mv[i] + offset_mv);
}

template <Method method, class Real>
void step(const Constants<Real>& c, std::size_t size, Tile<Real>& tile, Crossings<Real>& crossings) {
    const D<Real> d;
    const std::size_t lanes = hn::Lanes(d);
    const Span<Real> whole{all(c.step), all(c.decay), all(c.half_decay), all(c.fall)};
    std::uint8_t* bytes = tile.crossed.data();
    for (std::size_t i = 0; i < size; i += lanes) {
        V<Real> w = hn::Load(d, tile.w->data() + i);
        V<Real> g = hn::Load(d, tile.g->data() + i);
        advance<method>(whole, hn::Load(d, tile.b.data() + i), w, g);
        hn::Store(w, d, tile.next_w->data() + i);
        hn::Store(g, d, tile.next_g->data() + i);
        bytes += hn::StoreMaskBits(d, hn::Ge(w, hn::Load(d, tile.threshold.data() + i)), bytes);
    }
    // The flags are looked at 8 bytes at a time. Where a vector has fewer than 8 lanes, it has a byte.
    const std::size_t in_a_byte = std::min<std::size_t>(lanes, 8);
    const auto used = static_cast<std::size_t>(bytes - tile.crossed.data());
    std::memset(bytes, 0, std::min<std::size_t>(8, tile_size - used));
    crossings.count = 0;
    for (std::size_t at = 0; at < used; at += 8) {
        std::uint64_t flags = 0;
        std::memcpy(&flags, tile.crossed.data() + at, sizeof flags);
        for (; flags != 0; flags &= flags - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(flags));
            const std::size_t i = (at + bit / 8) * in_a_byte + bit % 8;
            const std::size_t k = crossings.count++;
            crossings.index[k] = static_cast<std::uint32_t>(i);
            crossings.w[k] = (*tile.w)[i];
            crossings.g[k] = (*tile.g)[i];
            crossings.b[k] = tile.b[i];
            crossings.threshold[k] = tile.threshold[i];
            crossings.delta_g[k] = tile.delta_g[i];
            crossings.end_w[k] = (*tile.next_w)[i];
            crossings.left[k] = c.step;
        }
    }
}

// The crossing within the step: on a straight line for Euler, otherwise by bracketed Newton on the length of
// the step. `end_w` holds w at the step's end, as if there were no threshold.
template <Method method, class Real>
HWY_INLINE V<Real> root(const Constants<Real>& c, const Crossings<Real>& at, std::size_t k,
                        V<Real>& g_at_root) {
    const D<Real> d;
    const V<Real> w0 = hn::Load(d, at.w.data() + k);
    const V<Real> g0 = hn::Load(d, at.g.data() + k);
    const V<Real> b = hn::Load(d, at.b.data() + k);
    const V<Real> threshold = hn::Load(d, at.threshold.data() + k);
    const V<Real> length = hn::Load(d, at.left.data() + k);
    const V<Real> end_w = hn::Load(d, at.end_w.data() + k);
    V<Real> low = hn::Zero(d);
    V<Real> high = length;
    V<Real> span = hn::Mul(length, hn::Div(hn::Sub(threshold, w0), hn::Sub(end_w, w0)));
    if constexpr (method != Method::euler) {
        const V<Real> enough = hn::Mul(all(4 * std::numeric_limits<Real>::epsilon()), length);
        auto open = hn::FirstN(d, std::min(hn::Lanes(d), at.count - k));
        for (int turn = 0; turn < 30 && !hn::AllFalse(d, open); ++turn) {
            const auto inside = hn::And(hn::Gt(span, low), hn::Lt(span, high));
            const V<Real> tried = hn::IfThenElse(inside, span, hn::Mul(all(Real(0.5)), hn::Add(low, high)));
            V<Real> w = w0;
            V<Real> g = g0;
            advance<method>(part<method>(c, tried), b, w, g);
            const auto below = hn::Lt(w, threshold);
            low = hn::IfThenElse(below, tried, low);
            high = hn::IfThenElse(below, high, tried);
            const V<Real> slope = hn::NegMulAdd(hn::Add(all(Real(1)), g), w, b);
            const V<Real> change = hn::Div(hn::Sub(w, threshold), slope);
            span = hn::IfThenElse(open, hn::Sub(tried, change), span);
            open = hn::And(open, hn::Gt(hn::Abs(change), enough));
        }
    }
    span = hn::Min(hn::Max(span, hn::Zero(d)), length);
    V<Real> w = w0;
    g_at_root = g0;
    advance<method>(part<method>(c, span), b, w, g_at_root);
    return span;
}

template <Method method, class Real>
void resolve(const Constants<Real>& c, Crossings<Real>& at) {
    const D<Real> d;
    for (std::size_t k = 0; k < at.count; k += hn::Lanes(d)) {
        V<Real> g = hn::Zero(d);
        const V<Real> span = root<method>(c, at, k, g);
        V<Real> w = all(c.reset);
        g = hn::Add(g, hn::Load(d, at.delta_g.data() + k));
        const V<Real> left = hn::Sub(hn::Load(d, at.left.data() + k), span);
        hn::Store(span, d, at.span.data() + k);
        hn::Store(w, d, at.w.data() + k);
        hn::Store(g, d, at.g.data() + k);
        hn::Store(left, d, at.left.data() + k);
        advance<method>(part<method>(c, left), hn::Load(d, at.b.data() + k), w, g);
        hn::Store(w, d, at.end_w.data() + k);
        hn::Store(g, d, at.end_g.data() + k);
    }
}

template <class Real>
void describe_any(Method method, Kernel<Real>& kernel) {
    switch (method) {
        case Method::euler:
            kernel = {&set_drives<Real>, &step<Method::euler, Real>, &resolve<Method::euler, Real>};
            break;
        case Method::exponential_euler:
            kernel = {&set_drives<Real>, &step<Method::exponential_euler, Real>,
                      &resolve<Method::exponential_euler, Real>};
            break;
        case Method::rk4:
            kernel = {&set_drives<Real>, &step<Method::rk4, Real>, &resolve<Method::rk4, Real>};
            break;
    }
}

}  // namespace

void describe_float(Method method, Kernel<float>& kernel) { describe_any(method, kernel); }
void describe_double(Method method, Kernel<double>& kernel) { describe_any(method, kernel); }

}  // namespace afferent::bench::stepping::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace afferent::bench::stepping {

HWY_EXPORT(describe_float);
HWY_EXPORT(describe_double);

void choose(Method method, Kernel<float>& kernel) { HWY_DYNAMIC_DISPATCH(describe_float)(method, kernel); }
void choose(Method method, Kernel<double>& kernel) { HWY_DYNAMIC_DISPATCH(describe_double)(method, kernel); }

}  // namespace afferent::bench::stepping
#endif
