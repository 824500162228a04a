// Counts allocations of this whole program, and so of the hot path.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/pushed_source.hpp"
#include "afferent/nodes/run.hpp"

namespace {

std::atomic<std::uint64_t> allocations{0};

void* counted(std::size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace afferent {
namespace {

// The allocations of a whole run, after assembly.
std::uint64_t allocations_of(const Plan& plan) {
    auto run = Run::open(plan, {});
    EXPECT_TRUE(run);
    const std::uint64_t before = allocations;
    while (!run.value()->done()) EXPECT_TRUE(run.value()->do_next());
    EXPECT_GT(run.value()->coprocessor().events(), 100U);
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

}  // namespace
}  // namespace afferent
