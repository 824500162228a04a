// A hand and its coprocessor, as two processes with a clock each, on a network on which anything may go
// wrong. The safety property of the hand is asserted all the time.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/hello.hpp"
#include "tests/faults/faulty_network.hpp"
#include "tests/faults/safety_property.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {

// A user who closes all the time. There is one afferent, and few steps: the decoder is not the subject. Its
// sensor reads 10 N at most, which brings the gain to 0 at 8.
inline std::string small_scene(const std::string& source, const std::string& more = "") {
    return R"(duration_s: 100000 gain { limit_n: 8 } link { tcp {} } patch { name: "thumb" elements: 1 sensor { rate_hz: 100 } }
        hand { emg_rate_hz: 200 user { close_at_s: 0 close_for_s: 99999 effort: 0.7 } )" +
           more + " } " + source;
}
// There is nothing to grasp: the command closes whenever it may.
inline std::string reaching(const std::string& more = "") {
    return small_scene("", "object { distance_mm: 500 } " + more);
}
// The gain decides.
inline std::string holding() { return small_scene("", "object { distance_mm: 3 stiffness_n_per_mm: 1 }"); }
// The samples are the coprocessor's, and are fed to it.
inline std::string fed() { return small_scene("source { standard_input {} }"); }

class FaultyNodes {
  public:
    MonotonicTime now = MonotonicTime(std::chrono::hours(1));
    FaultyNetwork network;

    FaultyNodes(const std::string& scene, NetworkKind kind)
        : network([this] { return now; }, kind),
          plan_(make_plan(Scene::from_text(scene), Commands::wanted)),
          property_(plan_),
          is_fed_(plan_.samples_from != SamplesFrom::hand) {
        network.to_hand = [this](const auto& message, Duration transit, Duration overtaken) {
            hear(message, transit, overtaken);
        };
        start_hand();
        start_coprocessor();
    }

    const Plan& plan() const { return plan_; }
    const SafetyProperty& property() const { return property_; }
    HandNode* hand() { return hand_.get(); }
    CoprocessorNode* coprocessor() { return coprocessor_.get(); }

    // Kills the hand, if there is one, and starts another.
    void start_hand() {
        hand_.reset();
        property_.hand_started();
        hand_ = value_or_throw(
            HandNode::open(plan_, network.listener(),
                           {.motor = [this](const ControllerStep& step) { property_.stepped(now, step); }},
                           {}, [this] { return now; }));
        hand_->start();
    }
    void start_coprocessor() {
        kill_coprocessor();
        coprocessor_ = value_or_throw(
            CoprocessorNode::open(plan_, network.connector(), {}, {}, [this] { return skewed(now); }));
        fed_until_ = scene_start;
        if (is_fed_) (void)coprocessor_->link_end().table()->feed("time_s,force_n\n");
        coprocessor_->start();
    }
    void kill_coprocessor() {
        coprocessor_.reset();
        ended_at_.reset();
    }

    void stop(FaultyNetwork::Side link_end, bool stopped) {
        network.stop(link_end, stopped);
        stopped_[link_end] = stopped;
    }

    // How much faster the coprocessor's clock is from here on.
    void drift(double ppm) {
        skewed_at_ = skewed(now);
        drift_since_ = now;
        rate_ = 1 + ppm * 1e-6;
    }
    // Sensors fall silent, where they are fed.
    void silence_sensors(bool silent) {
        if (!silent && coprocessor_) fed_until_ = std::max(fed_until_, coprocessor_->at());
        sensors_are_silent_ = silent;
    }

    void run_for(Duration length) {
        const MonotonicTime end = now + length;
        for (;;) {
            while (network.deliver()) {
            }
            MonotonicTime wake = end;
            poll_hand(wake);
            poll_coprocessor(wake);
            if (const auto arrival = network.next_arrival()) wake = std::min(wake, *arrival);
            if (now >= end) return;
            turns_in_vain_ = wake <= now ? turns_in_vain_ + 1 : 0;
            ASSERT_LT(turns_in_vain_, 1000) << "a node asks to be polled, and has nothing to do";
            now = std::max(now + 1us, wake);
        }
    }

  private:
    static constexpr Duration feed_period = 10ms;
    static constexpr Duration restart_pause = 100ms;

    void hear(const proto::Envelope& message, Duration transit, Duration overtaken) {
        if (message.has_hello()) property_.session_offered(message.hello().nonce());
        const bool measures = is_packet(message) && !message.has_no_samples_since_ns();
        // The delays of the two ways of a round trip cannot be told apart: the error is up to half of it.
        if (!measures || overtaken > plan_.timing.overtaking || transit > 2 * plan_.timing.stale) return;
        property_.heard(now);
    }

    void poll_hand(MonotonicTime& wake) {
        if (stopped_[FaultyNetwork::hand]) return;
        if (const auto next = hand_->poll()) {
            wake = std::min(wake, *next);
            property_.check(now);
        } else {
            property_.hand_ended(now, hand_->failure().value_or("at " + std::to_string(seconds(hand_->at())) +
                                                                " s of the scene"));
            start_hand();
        }
    }

    // It is started again, a while after it has ended.
    void poll_coprocessor(MonotonicTime& wake) {
        if (stopped_[FaultyNetwork::coprocessor] || !coprocessor_) return;
        if (ended_at_) {
            if (now - *ended_at_ < restart_pause) return;
            start_coprocessor();
        }
        if (is_fed_ && !sensors_are_silent_) feed();
        if (const auto next = coprocessor_->poll())
            wake = std::min(wake, now + std::chrono::ceil<Duration>(Interval(*next - skewed(now)) / rate_));
        else
            ended_at_ = now;
    }

    // A little ahead, as the rows of a table are.
    void feed() {
        for (; fed_until_ <= coprocessor_->at() + feed_period; fed_until_ += feed_period)
            (void)coprocessor_->link_end().table()->feed(std::to_string(seconds(fed_until_)) + ",1\n");
    }

    MonotonicTime skewed(MonotonicTime time) const {
        return skewed_at_ + std::chrono::duration_cast<Duration>(Interval(time - drift_since_) * rate_);
    }

    Plan plan_;
    SafetyProperty property_;
    bool is_fed_;
    MonotonicTime skewed_at_ = now + 1min;
    MonotonicTime drift_since_ = now;
    double rate_ = 1;
    std::array<bool, 2> stopped_{};
    bool sensors_are_silent_ = false;
    TimePoint fed_until_ = scene_start;
    int turns_in_vain_ = 0;
    std::optional<MonotonicTime> ended_at_;  // the coprocessor, by itself
    std::unique_ptr<HandNode> hand_;
    std::unique_ptr<CoprocessorNode> coprocessor_;
};

}  // namespace afferent
