// What must hold for a hand in every run, whatever happens to its link, its peers and its process:
//
//   1. The closing command is zero once the safe threshold and one step have passed since the last
//      authenticated packet in time.
//   2. It never exceeds what the gain of the last estimate allowed.
//   3. From the freeze threshold and one step on it does not grow.
//   4. After 1, closing goes on only with a new session whose packets arrive, two of them at least.
//
// Before the first packet the silence has lasted for ever.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/engine/controller.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Watches one hand. It is told every command, and what really reaches the hand; of the hand's own reports it
// uses the estimate only.
class SafetyProperty {
  public:
    explicit SafetyProperty(const Plan& plan)
        : gain_(plan.scene.gain),
          freeze_(plan.timing.freeze),
          safe_(plan.timing.safe),
          step_(from_seconds(1 / plan.scene.hand.emg_rate_hz)) {}

    // From here on the hand is another process.
    void hand_started() {
        heard_.reset();
        command_ = 0;
        expire();
        offered_ = false;
    }
    // A hello of the hand's own coprocessor arrives.
    void session_offered(std::uint64_t nonce) {
        if (nonce == nonce_) return;
        nonce_ = nonce;
        offered_ = true;
        has_closed_ = false;
    }
    // A packet of its session arrives that measures something, is not older than the scene allows, and did
    // not arrive before.
    void heard(MonotonicTime now) {
        if (is_silent(now, safe_)) expire();
        heard_ = now;
        if (offered_) ++rearmed_by_;
    }

    void stepped(MonotonicTime now, const ControllerStep& step) {
        const double closing = std::clamp(step.effort.closing, 0.0, 1.0);
        if (step.command > gain_(step.estimate.force_n) * closing + rounding)
            violate(now, "the command " + std::to_string(step.command) + " is above what the gain allows");
        if (is_silent(now, freeze_ + step_) && step.command > std::max(command_, 0.0))
            violate(now, "the command grows to " + std::to_string(step.command) + " in silence");
        command_ = step.command;
        if (command_ > 0) has_closed_ = true;
        check(now);
    }

    // To be called whenever the hand has had its turn: a command stands until the next.
    void check(MonotonicTime now) {
        if (is_silent(now, safe_ + step_)) expire();
        if (command_ <= 0) return;
        if (is_silent(now, safe_ + step_))
            violate(now, "the hand closes" + silence(now));
        else if (rearmed_by_ < packets_to_rearm)
            violate(now, "the hand closes again with " + std::to_string(rearmed_by_) +
                             " packets of a session that is " + (offered_ ? "new" : "spent"));
    }
    void hand_ended(MonotonicTime now, const std::string& why) {
        violate(now, "the hand has come to its end by itself: " + why);
    }

    bool closes() const noexcept { return command_ > 0; }
    // In words; the first few of them.
    const std::vector<std::string>& violations() const noexcept { return violations_; }

  private:
    static constexpr double rounding = 1e-12;
    static constexpr int packets_to_rearm = 2;
    static constexpr std::size_t most_violations = 5;

    bool is_silent(MonotonicTime now, Duration limit) const { return !heard_ || now - *heard_ >= limit; }
    std::string silence(MonotonicTime now) const {
        return heard_ ? ' ' + std::to_string((now - *heard_) / 1us) + " us after the last packet"
                      : " without any packet";
    }
    // A session in which the hand has closed is spent.
    void expire() {
        rearmed_by_ = 0;
        if (has_closed_) offered_ = false;
        has_closed_ = false;
    }
    void violate(MonotonicTime now, const std::string& what) {
        if (violations_.size() < most_violations)
            violations_.push_back(std::to_string(now.time_since_epoch() / 1us) + " us: " + what);
    }

    EmgGain gain_;
    Duration freeze_;
    Duration safe_;
    Duration step_;
    std::optional<MonotonicTime> heard_;
    double command_ = 0;
    std::uint64_t nonce_ = 0;
    bool offered_ = false;     // a session that is not spent
    bool has_closed_ = false;  // in it
    int rearmed_by_ = 0;       // packets of it, since the last long silence
    std::vector<std::string> violations_;
};

}  // namespace afferent
