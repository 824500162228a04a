// Scans of a hand that can be touched, such as no good hand gives, too.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>

#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

// Gives the scans that the test puts in, and keeps what it is told.
class ScriptedHand final : public HandDevice {
  public:
    void start(std::function<void()> fed) override {
        started = true;
        tell = std::move(fed);
    }
    void command(const DeviceCommand&) noexcept override {}
    const HandScan* next_scan() override {
        if (taken_) scans.pop_front();
        taken_ = !scans.empty();
        return taken_ ? &scans.front() : nullptr;
    }
    std::optional<std::string> next_note() override { return std::nullopt; }
    const HandReadings& readings() override { return readings_; }
    std::uint64_t dropped_scans() const noexcept override { return 0; }
    void take_zero() noexcept override { ++zeros; }

    bool started = false;
    std::function<void()> tell;  // that there is a scan
    int zeros = 0;
    std::deque<HandScan> scans;

  private:
    bool taken_ = false;
    HandReadings readings_;
};

Scene scene_with_hand(const std::vector<Setting>& settings = {}) {
    return Scene::from_file(AFFERENT_SOURCE_DIR "/examples/ability_hand.txtpb").with(settings);
}

struct TwoNodesWithHand {
    explicit TwoNodesWithHand(const std::vector<Setting>& settings = {}) : nodes(scene_with_hand(settings)) {
        auto device = std::make_unique<ScriptedHand>();
        hand = device.get();
        nodes.start_hand(nodes.links.listener(), {}, std::move(device));
    }
    void give(double force_n, MonotonicTime when) {
        hand->scans.push_back({when, std::vector<double>(nodes.plan.elements, force_n)});
    }
    // A good scan each 5 ms.
    void give_for(Duration span, double force_n) {
        for (Duration since{}; since < span; since += 5ms) {
            give(force_n, nodes.now);
            nodes.run_for(5ms);
        }
    }
    std::size_t complaints() const {
        return static_cast<std::size_t>(
            std::ranges::count_if(nodes.hand.session, [](const std::string& said) {
                return said.find("scans of the hand are not used") != std::string::npos;
            }));
    }
    std::uint64_t sampled() const { return nodes.coprocessor.node->report().counts.samples; }
    std::uint64_t dropped() const { return nodes.hand.node->report().dropped_scans; }

    TwoNodes nodes;
    ScriptedHand* hand = nullptr;
};

TEST(HandScans, AreToldOfToWhoeverWantsToKnow) {
    int told = 0;
    for (const NodeOptions& options : {NodeOptions(), NodeOptions{.fed = [&] { ++told; }}}) {
        TwoNodes nodes(scene_with_hand());
        auto device = std::make_unique<ScriptedHand>();
        const ScriptedHand& hand = *device;
        nodes.start_hand(nodes.links.listener(), options, std::move(device));
        ASSERT_TRUE(hand.tell);
        hand.tell();
    }
    EXPECT_EQ(told, 1);
}

TEST(HandScans, AreAskedForOnceTheNodeHasBegun) {
    TwoNodesWithHand two;
    EXPECT_TRUE(two.hand->started);
    two.nodes.hand.node->take_zero();
    EXPECT_EQ(two.hand->zeros, 1);
    // Without a hand there is none that could take its zero.
    TwoNodes without("duration_s: 1 link { tcp {} }");
    without.start();
    without.hand.node->take_zero();
}

TEST(HandScans, AreSentOnceEach) {
    TwoNodesWithHand two;
    two.nodes.start_coprocessor();
    two.give_for(500ms, 1);
    const std::uint64_t before = two.sampled();
    EXPECT_GT(before, 50 * std::uint64_t{two.nodes.plan.elements});
    // One of a time that was told already, and one of before that.
    const MonotonicTime last = two.nodes.now - 5ms;
    two.give(5, last);
    two.give(5, last - 2ms);
    two.nodes.run_for(5ms);
    EXPECT_EQ(two.sampled(), before);
    two.give_for(5ms, 1);
    EXPECT_EQ(two.sampled(), before + two.nodes.plan.elements);
    EXPECT_EQ(two.complaints(), 0U);
}

TEST(HandScans, OfAfterTheSceneChangeNothing) {
    TwoNodesWithHand two({Setting::from("duration_s=0.3")});
    two.nodes.start_coprocessor();
    two.give_for(100ms, 1);
    // On such a link the coprocessor's bye comes after scans of the time after the scene.
    two.nodes.links.set_latency(15ms);
    two.give_for(210ms, 1);
    const auto fed = [&] { return two.nodes.hand.node->report().feed_bytes; };
    const std::uint64_t fed_by_the_end = fed();
    two.give_for(290ms, 1);
    EXPECT_EQ(fed(), fed_by_the_end);
    EXPECT_LE(two.sampled(), 61 * std::uint64_t{two.nodes.plan.elements});
    EXPECT_GT(two.sampled(), 40 * std::uint64_t{two.nodes.plan.elements});
    EXPECT_EQ(two.nodes.coprocessor.node->report().broken_sessions, 0U);
    EXPECT_EQ(two.nodes.coprocessor.last_of_session(), "the session has ended: this is the end of the scene");
}

TEST(HandScans, ThatNoHandCanMeasureAreRefusedAndToldOfOnce) {
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double wrong_n : {infinity, -infinity, std::nan(""), -0.5}) {
        TwoNodesWithHand two;
        two.nodes.start_coprocessor();
        two.give_for(100ms, 1);
        const std::uint64_t before = two.sampled();
        two.give_for(50ms, wrong_n);
        EXPECT_EQ(two.sampled(), before) << wrong_n;
        EXPECT_EQ(two.dropped(), 10U) << wrong_n;
        EXPECT_EQ(two.complaints(), 1U) << wrong_n;
        two.give_for(50ms, 1);
        EXPECT_GT(two.sampled(), before) << "good ones are used again";
    }
}

TEST(HandScans, WithoutASessionAreTakenAndForgotten) {
    TwoNodesWithHand two;
    two.give_for(100ms, 1);
    EXPECT_TRUE(two.hand->scans.size() <= 1) << "nothing piles up";
    two.nodes.start_coprocessor();
    two.give_for(100ms, 1);
    EXPECT_GT(two.sampled(), 0U);
    two.nodes.kill_coprocessor();
    two.give_for(300ms, 1);
    two.give_for(50ms, -1);
    EXPECT_TRUE(two.hand->scans.size() <= 1);
    EXPECT_EQ(two.complaints(), 0U);
}

TEST(HandScans, NeedASceneAndAMannerOfTheHand) {
    const auto why_not = [](const Scene& scene, bool gives_hand, const NodeOptions& options) {
        TwoNodes nodes(scene);
        std::unique_ptr<HandDevice> device;
        if (gives_hand) device = std::make_unique<ScriptedHand>();
        const auto opened = HandNode::open(
            nodes.plan, nodes.links.listener(), options, {}, [&] { return nodes.now; }, std::move(device));
        return opened ? "" : opened.error().text;
    };
    EXPECT_EQ(why_not(scene_with_hand(), true, {}), "");
    EXPECT_NE(why_not(scene_with_hand(), true, {.lockstep = true}).find("and not in lockstep"),
              std::string::npos);
    EXPECT_NE(why_not(Scene::from_text("link { tcp {} }"), true, {}).find("no hand.ability_hand"),
              std::string::npos);
    // The scene's own line is opened where no hand is given; there is none.
    const Scene nowhere = scene_with_hand({Setting::from("hand.ability_hand.port=/no/such/line")});
    EXPECT_EQ(why_not(nowhere, true, {}), "");
    EXPECT_NE(why_not(nowhere, false, {}).find("/no/such/line"), std::string::npos);
}

}  // namespace
}  // namespace afferent
