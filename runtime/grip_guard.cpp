#include "afferent/runtime/grip_guard.hpp"

#include <algorithm>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

std::string milliseconds(Duration duration) {
    return std::to_string(std::chrono::round<std::chrono::milliseconds>(duration).count()) + " ms";
}

}  // namespace

std::string text(const GripCause& cause) {
    switch (cause.kind) {
        case GripCause::Kind::none:
            return "";
        case GripCause::Kind::no_session:
            return "no coprocessor has been there yet";
        case GripCause::Kind::silence:
            return "no packet for " + milliseconds(cause.figure);
        case GripCause::Kind::stale_packets:
            return cause.figure == Duration::max()
                       ? "packets arrive, and how old they are is not known"
                       : "packets are " + milliseconds(cause.figure) + " old when they arrive";
        case GripCause::Kind::no_samples:
            return "no samples from the sensors" +
                   (cause.figure == Duration::zero() ? "" : " for " + milliseconds(cause.figure));
        case GripCause::Kind::session_ended:
            return cause.figure == Duration::zero()
                       ? "the session has ended"
                       : "no packet for " + milliseconds(cause.figure) + ": the session has ended";
        case GripCause::Kind::awaits_user:
            return "waits for the user's acknowledgement";
    }
    return "";
}

GripGuard::GripGuard(const Limits& limits, MonotonicTime now)
    : limits_(limits), latest_(now), trusted_until_(now), heard_(now), steady_since_(now) {
    const double freeze_ms = Milliseconds(limits.freeze).count();
    const double safe_ms = Milliseconds(limits.safe).count();
    require(freeze_ms > 0, "freeze_ms", "> 0", freeze_ms);
    require(safe_ms > freeze_ms, "safe_ms", "> freeze_ms", safe_ms);
}

GripGuard GripGuard::within_session(const Limits& limits, MonotonicTime now) {
    GripGuard guard(limits, now);
    guard.trust();
    return guard;
}

void GripGuard::session_opened(MonotonicTime now) noexcept {
    session_ended(now);
    session_ = Session::fresh;
    heard_ = steady_since_ = latest_;
}

void GripGuard::session_ended(MonotonicTime now) noexcept {
    settle(now);
    if (session_ == Session::trusted) {
        silence_ = {GripCause::Kind::session_ended};
        if (state_ == GripState::operating) {
            state_ = GripState::frozen;
            cause_ = silence_;
        }
    }
    if (cause_.kind == GripCause::Kind::awaits_user) cause_ = {GripCause::Kind::session_ended};
    session_ = Session::none;
}

void GripGuard::heard(MonotonicTime now) noexcept {
    settle(now);
    if (session_ == Session::trusted) {
        trusted_until_ = std::max(trusted_until_, now);
        silence_ = {GripCause::Kind::silence};
        state_ = GripState::operating;
        cause_ = {};
    } else if (session_ == Session::fresh) {
        if (now - heard_ >= limits_.freeze) steady_since_ = now;
        heard_ = std::max(heard_, now);
        if (!proved()) return;
        if (state_ == GripState::safe && limits_.rearm == Rearm::by_user)
            cause_ = {GripCause::Kind::awaits_user};
        else
            trust();
    }
    settle(latest_);
}

void GripGuard::stale(MonotonicTime now, Duration age) noexcept {
    measure_nothing(now, {GripCause::Kind::stale_packets, age});
}

void GripGuard::without_samples(MonotonicTime now) noexcept {
    measure_nothing(now, {GripCause::Kind::no_samples});
}

void GripGuard::measure_nothing(MonotonicTime now, const GripCause& why) noexcept {
    settle(now);
    if (session_ == Session::trusted) silence_ = why;
    // What keeps the session from proving itself is what the user has to know now.
    if (session_ == Session::fresh && state_ == GripState::safe &&
        cause_.kind != GripCause::Kind::awaits_user)
        cause_ = why;
}

void GripGuard::acknowledged(MonotonicTime now) noexcept {
    settle(now);
    if (cause_.kind == GripCause::Kind::awaits_user) trust();
}

GripState GripGuard::state(MonotonicTime now) noexcept {
    settle(now);
    return state_;
}

// Carries out what time alone has brought about.
void GripGuard::settle(MonotonicTime now) noexcept {
    latest_ = std::max(latest_, now);
    if (cause_.kind == GripCause::Kind::awaits_user && latest_ - heard_ >= limits_.freeze)
        cause_ = {GripCause::Kind::silence, limits_.freeze};
    if (state_ == GripState::safe) return;
    const Duration silence = latest_ - trusted_until_;
    if (silence >= limits_.safe) {
        enter(GripState::safe, limits_.safe);
        if (session_ == Session::trusted) session_ = Session::spent;
    } else if (silence >= limits_.freeze && state_ == GripState::operating) {
        enter(GripState::frozen, limits_.freeze);
    }
}

// After a silence that has lasted that long.
void GripGuard::enter(GripState state, Duration silence) noexcept {
    state_ = state;
    cause_ = silence_;
    if (cause_.kind != GripCause::Kind::stale_packets) cause_.figure = silence;
}

void GripGuard::trust() noexcept {
    session_ = Session::trusted;
    trusted_until_ = heard_;
    silence_ = {GripCause::Kind::silence};
    state_ = GripState::operating;
    cause_ = {};
}

}  // namespace afferent
