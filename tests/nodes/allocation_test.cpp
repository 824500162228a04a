// Counts allocations of this whole program, and so of the hot path.
#include <gtest/gtest.h>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/pushed_source.hpp"
#include "afferent/nodes/run.hpp"
#include "tests/counted_allocations.hpp"
#include "tests/nodes/two_nodes.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

// The allocations of a whole run, after assembly.
std::uint64_t allocations_of(const Plan& plan) {
    const auto run = value_or_throw(Run::open(plan, {}));
    const std::uint64_t before = allocations;
    while (!run->done()) value_or_throw(run->do_next());
    EXPECT_GT(run->coprocessor().events(), 100U);
    return allocations - before;
}

TEST(Allocation, OfTheGraspIsNoneAfterAssembly) {
    EXPECT_EQ(allocations_of(make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb"))), 0U);
}

TEST(Allocation, IsNoneWithTwoChannelsAndWithoutPackets) {
    EXPECT_EQ(allocations_of(make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/two_channels.txtpb"))),
              0U);
    EXPECT_EQ(allocations_of(make_plan(Scene::from_text("link { in_process {} }"))), 0U);
}

TEST(Allocation, IsNoneWithEstimatesOfEachElement) {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb");
    scene.decoder.parts = scene::Parts::elements;
    EXPECT_EQ(allocations_of(make_plan(scene)), 0U);
}

TEST(Allocation, IsNoneWhereSpikesArePresumed) {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb");
    scene.link.encoding = scene::Encoding::predicted;
    scene.link.timing_tolerance_us = 500;
    for (const bool filters : {false, true}) {
        if (filters) scene.decoder.kind = scene::Filter();
        scene.decoder.parts = scene::Parts::elements;
        EXPECT_EQ(allocations_of(make_plan(scene)), 0U) << filters;
    }
}

// A stimulus makes room for what it touches, with read-outs as without.
TEST(Allocation, IsNoMoreWithReadouts) {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/fingertip.txtpb");
    scene.decoder.kind = scene::Filter();
    scene.record.force = true;
    const std::uint64_t without = allocations_of(make_plan(scene));
    scene.decoder.contact.emplace();
    scene.decoder.edge.emplace();
    scene.decoder.texture.emplace();
    EXPECT_EQ(allocations_of(make_plan(scene)), without);
}

TEST(Allocation, OfAControllerIsNoneAfterConstruction) {
    const Plan plan = make_plan(Scene::from_text("link { tcp {} }"), Commands::wanted);
    Packetizer packetizer(*plan.packets);
    FrameWriter writer;
    std::vector<std::vector<std::byte>> frames;
    for (int k = 0; k < 200; ++k) {
        const TimePoint begin = scene_start + k * 5ms;
        std::vector<Event> events;
        for (Address address = 0; address < plan.addresses; ++address)
            events.push_back({begin + 1ms, address});
        packetizer.push(events);
        packetizer.close(begin + 5ms, [&](const auto& packet) {
            const auto bytes = writer.datagram(packet);
            frames.emplace_back(bytes.begin(), bytes.end());
        });
    }
    Controller controller(plan);
    const std::uint64_t before = allocations;
    TimePoint now = scene_start;
    for (const auto& frame : frames) {
        ASSERT_TRUE(controller.receive(frame));
        for (int step = 0; step < 5; ++step) controller.step(now += 1ms, {2300, 2048});
    }
    EXPECT_EQ(allocations - before, 0U);
    EXPECT_GT(controller.last_step().estimate.force_n, 1);
}

TEST(Allocation, IsNoneWithABus) {
    EXPECT_EQ(allocations_of(make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/bus.txtpb"))), 0U);
}

TEST(Allocation, OfPushedScansIsNoneAfterTheFirstRound) {
    const Plan plan = make_plan(Scene::from_text("patch { name: \"tip\" elements: 100 }"));
    PushedSource source(plan, 4);
    const std::vector<double> forces_n(100, 1.0);
    const auto push = [&](int k) { return source.push({scene_start + k * 1ms, 0, forces_n}).has_value(); };
    int k = 0;
    while (k < 4) ASSERT_TRUE(push(k++));
    const std::uint64_t before = allocations;
    while (k < 100) {
        ASSERT_TRUE(push(k++));
        if (k % 3 == 0) {
            ASSERT_TRUE(source.take(0));
        }
    }
    EXPECT_EQ(allocations, before);
}

// A hand's loop with what comes from its link, which is put in by another thread and not counted.
class CountedLoop {
  public:
    explicit CountedLoop(const std::string& scene)
        : plan_(make_plan(Scene::from_text(scene), Commands::wanted)),
          loop_(plan_, value_or_throw(HandEnd::open(plan_)), {.keeps_messages = true},
                [this] { return now_; }) {}

    GripInbox& inbox() { return loop_.inbox(); }
    MonotonicTime now() const { return now_; }
    GripState state() { return loop_.report().state; }
    std::uint64_t allocated() const { return allocated_; }
    std::optional<std::string> failure() const { return loop_.failure(); }

    void begin_session() {
        inbox().opened(now_, {});
        if (began_)
            inbox().restart(now_);
        else
            inbox().begin(now_, scene_start, nullptr);
        began_ = true;
    }
    void run_for(Duration length) {
        for (const MonotonicTime end = now_ + length; now_ < end; now_ += 1ms) poll();
    }
    // A packet each 5 ms, with an event of every afferent.
    void hear_for(Duration length, const Reception& like = {}) {
        for (const MonotonicTime end = now_ + length; now_ < end;) {
            run_for(5ms);
            const TimePoint known = scene_start + (now_ - begin_);
            std::vector<Event> events;
            for (Address address = 0; address < plan_.addresses; ++address)
                events.push_back({known - 1ms, address});
            Reception reception = like;
            if (reception.usable()) {
                reception.known = {known - 5ms, known};
                reception.events = events;
            } else {
                reception.gap = {known - 5ms, known};
                reception.known = {known, known};
            }
            inbox().receive(reception, {}, now_);
            proto::Envelope packet;
            packet.set_position(1);
            packet.set_payload(std::string(40, 'x'));
            inbox().packet(packet);
        }
    }

  private:
    void poll() {
        const std::uint64_t before = allocations;
        loop_.poll();
        allocated_ += allocations - before;
        while (loop_.records().next()) loop_.records().pop();
        while (loop_.scans().next()) loop_.scans().pop();
    }

    Plan plan_;
    MonotonicTime begin_ = MonotonicTime(std::chrono::hours(1));
    MonotonicTime now_ = begin_;
    bool began_ = false;
    std::uint64_t allocated_ = 0;
    GripLoop loop_;
};

TEST(Allocation, OfAHandsLoopIsNoneFromItsStartWhateverComes) {
    CountedLoop it(grasp("", 20));
    it.begin_session();
    it.hear_for(500ms);
    EXPECT_EQ(it.state(), GripState::operating);
    it.run_for(80ms);
    EXPECT_EQ(it.state(), GripState::frozen);
    it.inbox().steer(it.now(), 1ms);
    it.run_for(200ms);
    EXPECT_EQ(it.state(), GripState::safe);
    // Packets that are stale, without samples, after a loss, or refused.
    it.hear_for(100ms, {.gap = {}, .known = {}, .events = {}, .stale = true, .age = 90ms});
    it.hear_for(100ms, {.gap = {}, .known = {}, .events = {}, .no_samples = true});
    it.inbox().packet({});
    it.inbox().acknowledged(it.now());
    it.inbox().ended(it.now(), proto::Bye());
    it.run_for(50ms);
    it.begin_session();
    it.hear_for(300ms);
    EXPECT_EQ(it.state(), GripState::operating);
    it.run_for(40ms);
    it.hear_for(1s);
    it.inbox().stop();
    it.run_for(5ms);
    EXPECT_EQ(it.allocated(), 0U);
}

TEST(Allocation, OfAHandsLoopIsNoneWithReadouts) {
    CountedLoop it(
        "duration_s: 20 patch { name: 'tip' kind: SA1 outline {} } source { pushed {} } link { tcp {} } "
        "decoder { filter {} contact {} edge { settle_ms: 10 } texture { window_ms: 50 } }");
    it.begin_session();
    it.hear_for(200ms);
    EXPECT_EQ(it.state(), GripState::operating);
    it.run_for(80ms);
    it.hear_for(200ms);
    EXPECT_EQ(it.state(), GripState::operating);
    EXPECT_EQ(it.allocated(), 0U);
}

// The scan that cannot be taken, too.
TEST(Allocation, OfAHandsLoopIsNoneWhereItsSamplesFail) {
    CountedLoop it(grasp("", 20,
                         "every_patch { sensor { full_scale_n: 0.1 out_of_range: REFUSE } } "
                         "gain { accept_unreachable_limit: true doubtful: AS_ESTIMATED }"));
    it.begin_session();
    it.hear_for(2s);
    ASSERT_TRUE(it.failure());
    EXPECT_NE(it.failure()->find("a force beyond full scale at "), std::string::npos) << *it.failure();
    EXPECT_EQ(it.allocated(), 0U);
}

TEST(Allocation, OfAReceptionThatIsKeptIsDoneBeforehand) {
    const std::vector<Event> events(10);
    Reception told;
    told.events = told.presumed = events;
    KeptReception kept;
    kept.make_room(events.size());
    const std::uint64_t before = allocations;
    kept.keep(told);
    EXPECT_EQ(allocations, before);
    EXPECT_EQ(kept.presumed.size(), 10U);
}

}  // namespace
}  // namespace afferent
