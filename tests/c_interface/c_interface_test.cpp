#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "afferent/engine/afferent.h"

namespace {

constexpr const char* scene = "patch { name: 'a' elements: 3 }";

struct Handle {
    explicit Handle(const char* text) : coprocessor(afferent_open_text(text)) {}
    ~Handle() { afferent_close(coprocessor); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    afferent_t* coprocessor;
};

TEST(CInterface, TellsWhyASceneIsRefused) {
    EXPECT_EQ(afferent_open_text("patch { elements: 0 name: 'a' }"), nullptr);
    EXPECT_NE(std::string(afferent_error(nullptr)).find("elements must be 1 to"), std::string::npos);
    EXPECT_EQ(afferent_open_file("/nowhere"), nullptr);
    EXPECT_NE(std::string(afferent_error(nullptr)).find("/nowhere"), std::string::npos);
    EXPECT_EQ(afferent_open_text(nullptr), nullptr);
}

TEST(CInterface, GivesTheSameEventsThroughASmallBuffer) {
    const double forces_n[] = {3, 2, 1};
    const auto events = [&](std::size_t capacity) {
        const Handle handle(scene);
        EXPECT_EQ(afferent_addresses(handle.coprocessor), 3U);
        EXPECT_EQ(afferent_elements(handle.coprocessor), 3U);
        EXPECT_EQ(afferent_push(handle.coprocessor, 0, 0, forces_n, 3), AFFERENT_OK);
        std::vector<std::pair<std::int64_t, std::uint32_t>> all;
        std::vector<afferent_event> buffer(capacity);
        long count = 0;
        do {
            count = afferent_advance(handle.coprocessor, 1'000'000'000, buffer.data(), capacity);
            EXPECT_GE(count, 0);
            for (long i = 0; i < count; ++i) {
                const auto& event = buffer[static_cast<std::size_t>(i)];
                all.emplace_back(event.time_ns, event.address);
            }
        } while (count == static_cast<long>(capacity));
        return all;
    };
    const auto at_once = events(10'000);
    EXPECT_GT(at_once.size(), 20U);
    EXPECT_TRUE(std::is_sorted(at_once.begin(), at_once.end()));
    EXPECT_EQ(events(7), at_once);
}

// Asking for a time far ahead takes as long as computing the events asked for, and no memory for the others.
TEST(CInterface, ComputesNoMoreThanIsAskedFor) {
    constexpr std::int64_t end = std::numeric_limits<std::int64_t>::max();
    const double force_n = 5;
    afferent_event few[50];
    afferent_event same[50];
    const Handle handle(scene);
    const Handle other(scene);
    EXPECT_EQ(afferent_advance(other.coprocessor, end, few, 50), 0) << "nobody fires at rest";
    for (const Handle* each : {&handle, &other}) {
        afferent_reset(each->coprocessor);
        ASSERT_EQ(afferent_push(each->coprocessor, 0, 0, &force_n, 1), AFFERENT_OK);
    }
    for (int i = 0; i < 20; ++i) {
        ASSERT_EQ(afferent_advance(handle.coprocessor, end, few, 50), 50);
        ASSERT_EQ(afferent_advance(other.coprocessor, few[49].time_ns, same, 50), 50);
        for (int k = 0; k < 50; ++k) ASSERT_EQ(few[k].time_ns, same[k].time_ns);
    }
    EXPECT_EQ(afferent_advance(handle.coprocessor, end, nullptr, 0), 0) << "no room, and no harm";
}

// Time up to the last call is past, computed or not.
TEST(CInterface, TakesASampleFromThePastNow) {
    const double force_n = 9;
    std::vector<std::int64_t> first_ns;
    for (const std::size_t capacity : {std::size_t{0}, std::size_t{10'000}}) {
        const Handle handle("patch { name: 'a' elements: 2 }");
        std::vector<afferent_event> events(10'000);
        ASSERT_EQ(afferent_push(handle.coprocessor, 0, 0, &force_n, 1), AFFERENT_OK);
        ASSERT_GE(afferent_advance(handle.coprocessor, 1'000'000'000, events.data(), capacity), 0);
        ASSERT_EQ(afferent_push(handle.coprocessor, 0, 1, &force_n, 1), AFFERENT_OK);
        const long count = afferent_advance(handle.coprocessor, 2'000'000'000, events.data(), events.size());
        ASSERT_GT(count, 0);
        const auto fires = std::find_if(events.begin(), events.begin() + count,
                                        [](const afferent_event& event) { return event.address == 1; });
        ASSERT_NE(fires, events.begin() + count);
        first_ns.push_back(fires->time_ns);
        EXPECT_GT(fires->time_ns, 1'000'000'000);
    }
    EXPECT_EQ(first_ns[0], first_ns[1]);
}

TEST(CInterface, BoundsTheSamplesThatWait) {
    const Handle handle(scene);
    const std::vector<double> forces_n(3, 1.0);
    int result = AFFERENT_OK;
    std::int64_t pushes = 0;
    for (; pushes < 1'000'000 && result == AFFERENT_OK; ++pushes)
        result = afferent_push(handle.coprocessor, pushes * 1'000, 0, forces_n.data(), 3);
    EXPECT_EQ(result, AFFERENT_FULL);
    EXPECT_EQ(pushes, (1 << 20) / 3 + 1);
    EXPECT_NE(std::string(afferent_error(handle.coprocessor)).find("advance"), std::string::npos);
    std::vector<afferent_event> events(100'000);
    EXPECT_GE(afferent_advance(handle.coprocessor, pushes * 1'000, events.data(), events.size()), 0);
    EXPECT_EQ(afferent_push(handle.coprocessor, pushes * 1'000, 0, forces_n.data(), 3), AFFERENT_OK);
}

TEST(CInterface, TakesAbsurdForcesAsATableDoes) {
    const auto events = [](const std::string& sensor, double force_n) {
        const Handle handle(
            ("source { pushed {} } patch { name: 'a' elements: 1 sensor { " + sensor + " } }").c_str());
        std::vector<afferent_event> all(10'000);
        const int pushed = afferent_push(handle.coprocessor, 0, 0, &force_n, 1);
        const long count = afferent_advance(handle.coprocessor, 1'000'000'000, all.data(), all.size());
        return std::tuple(pushed, count, afferent_clipped(handle.coprocessor));
    };
    const long highest = std::get<1>(events("", 10));
    EXPECT_GT(highest, 10);
    EXPECT_EQ(events("", 1e300), std::tuple(int{AFFERENT_OK}, highest, std::uint64_t{1}));
    EXPECT_EQ(events("", -1e300), std::tuple(int{AFFERENT_OK}, 0L, std::uint64_t{1}));
    EXPECT_EQ(events("out_of_range: REFUSE", 11), std::tuple(int{AFFERENT_FAILED}, 0L, std::uint64_t{0}));
    EXPECT_EQ(events("", std::numeric_limits<double>::infinity()),
              std::tuple(int{AFFERENT_FAILED}, 0L, std::uint64_t{0}));
}

TEST(CInterface, StartsAnewAfterAReset) {
    const Handle handle(scene);
    const double force_n = 5;
    afferent_event first[100];
    afferent_event second[100];
    afferent_push(handle.coprocessor, 0, 0, &force_n, 1);
    const long count = afferent_advance(handle.coprocessor, 100'000'000, first, 100);
    ASSERT_EQ(afferent_reset(handle.coprocessor), AFFERENT_OK);
    afferent_push(handle.coprocessor, 0, 0, &force_n, 1);
    ASSERT_EQ(afferent_advance(handle.coprocessor, 100'000'000, second, 100), count);
    for (long i = 0; i < count; ++i) EXPECT_EQ(first[i].time_ns, second[i].time_ns);
}

TEST(CInterface, RefusesWhatIsNoSample) {
    const Handle handle(scene);
    const double bad[] = {1, std::numeric_limits<double>::quiet_NaN(), 1};
    EXPECT_EQ(afferent_push(handle.coprocessor, 0, 0, bad, 3), AFFERENT_FAILED);
    EXPECT_NE(std::string(afferent_error(handle.coprocessor)), "");
    const double good = 1;
    EXPECT_EQ(afferent_push(handle.coprocessor, 0, 3, &good, 1), AFFERENT_FAILED) << "there is no element 3";
    EXPECT_EQ(afferent_push(handle.coprocessor, 0, 0, nullptr, 1), AFFERENT_FAILED);
    EXPECT_EQ(afferent_advance(nullptr, 0, nullptr, 0), AFFERENT_FAILED);
    afferent_close(nullptr);
}

// A storm is an error text and no exception.
TEST(CInterface, ReportsAStorm) {
    const Handle handle(
        "source { pushed {} } patch { name: 'a' elements: 1 encoder { sustained { gain_mv_per_n: 1 bias_mv: "
        "1e9 } } } "
        "runtime { spikes_per_window: 10 }");
    EXPECT_LT(afferent_advance(handle.coprocessor, 1'000'000'000, nullptr, 0), 0);
    EXPECT_NE(std::string(afferent_error(handle.coprocessor)).find("address 0"), std::string::npos);
}

struct ControllerHandle {
    explicit ControllerHandle(const char* text) : controller(afferent_controller_open_text(text)) {}
    ~ControllerHandle() { afferent_controller_close(controller); }
    ControllerHandle(const ControllerHandle&) = delete;
    ControllerHandle& operator=(const ControllerHandle&) = delete;
    afferent_controller_t* controller;
};

// Twenty spans of 5 ms with so many spikes of each of three neurons, and 5 steps after each.
afferent_step drive(afferent_controller_t* controller, int first_span, int spans, int spikes) {
    afferent_step step{};
    for (int k = first_span; k < first_span + spans; ++k) {
        const std::int64_t begin_ns = k * 5'000'000LL;
        std::vector<afferent_event> events;
        for (int spike = 0; spike < spikes; ++spike)
            for (std::uint32_t address = 0; address < 3; ++address)
                events.push_back({begin_ns + spike * 1'000'000LL, address});
        EXPECT_EQ(afferent_controller_observe(controller, begin_ns, begin_ns + 5'000'000, events.data(),
                                              events.size()),
                  AFFERENT_OK)
            << afferent_controller_error(controller);
        for (int ms = 1; ms <= 5; ++ms) {
            EXPECT_EQ(afferent_controller_step(controller, begin_ns + 5'000'000 + ms * 1'000'000LL, 2298,
                                               2048, &step),
                      AFFERENT_OK);
        }
    }
    return step;
}

TEST(CController, EstimatesAndTurnsTheUserDown) {
    const ControllerHandle handle(scene);
    ASSERT_NE(handle.controller, nullptr) << afferent_controller_error(nullptr);
    const afferent_step idle = drive(handle.controller, 0, 40, 0);
    EXPECT_EQ(idle.force_n, 0);
    EXPECT_EQ(idle.gain, 1);
    EXPECT_EQ(idle.doubt, AFFERENT_DOUBT_NONE);
    EXPECT_GT(idle.command, 0.1) << "the user closes";
    const afferent_step gripped = drive(handle.controller, 40, 40, 1);
    EXPECT_GT(gripped.force_n, 10);
    EXPECT_EQ(gripped.command, 0) << "beyond the limit";
    EXPECT_EQ(afferent_controller_set_state(handle.controller, AFFERENT_SAFE), AFFERENT_OK);
    EXPECT_LE(drive(handle.controller, 80, 20, 0).command, 0);
}

TEST(CController, SaysWhyTheForceMayBeLarger) {
    const ControllerHandle handle((std::string(scene) + "decoder { parts: ELEMENTS }").c_str());
    ASSERT_NE(handle.controller, nullptr) << afferent_controller_error(nullptr);
    afferent_step step{};
    ASSERT_EQ(afferent_controller_step(handle.controller, 0, 2298, 2048, &step), AFFERENT_OK);
    EXPECT_EQ(step.doubt, AFFERENT_DOUBT_UNKNOWN) << "nothing has been heard";
    EXPECT_LE(step.command, 0);
    // A thousand spikes a second are more than any sensor can cause.
    EXPECT_EQ(drive(handle.controller, 0, 40, 5).doubt, AFFERENT_DOUBT_SATURATED);
    int doubt = -1;
    EXPECT_EQ(afferent_controller_part_doubt(handle.controller, 2, &doubt), AFFERENT_OK);
    EXPECT_EQ(doubt, AFFERENT_DOUBT_SATURATED);
    EXPECT_EQ(afferent_controller_part_doubt(handle.controller, 3, &doubt), AFFERENT_FAILED);
    EXPECT_EQ(afferent_controller_part_doubt(nullptr, 0, &doubt), AFFERENT_FAILED);
    EXPECT_STREQ(afferent_doubt_name(AFFERENT_DOUBT_SATURATED), "saturated");
    for (const int none : {0, -1, 6}) EXPECT_STREQ(afferent_doubt_name(none), "none");
}

TEST(CController, ContinuesFromASnapshot) {
    const ControllerHandle one(scene);
    const ControllerHandle other(scene);
    drive(one.controller, 0, 30, 1);
    afferent_snapshot_t* snapshot = afferent_controller_snapshot(one.controller);
    ASSERT_NE(snapshot, nullptr);
    EXPECT_EQ(afferent_controller_resume(other.controller, snapshot), AFFERENT_OK);
    afferent_snapshot_free(snapshot);
    const afferent_step a = drive(one.controller, 30, 10, 0);
    const afferent_step b = drive(other.controller, 30, 10, 0);
    EXPECT_EQ(a.force_n, b.force_n);
    EXPECT_EQ(a.sigma_n, b.sigma_n);
    EXPECT_EQ(a.command, b.command);
}

TEST(CController, TellsTheForceOfEachPart) {
    const ControllerHandle handle((std::string(scene) + "decoder { parts: ELEMENTS }").c_str());
    ASSERT_NE(handle.controller, nullptr) << afferent_controller_error(nullptr);
    ASSERT_EQ(afferent_controller_parts(handle.controller), 3U);
    const afferent_step gripped = drive(handle.controller, 0, 40, 1);
    double force_n = 0;
    double sigma_n = -1;
    double sum_n = 0;
    for (std::size_t part = 0; part < 3; ++part) {
        EXPECT_EQ(afferent_controller_part(handle.controller, part, &force_n, &sigma_n), AFFERENT_OK);
        EXPECT_GE(sigma_n, 0);
        sum_n += force_n;
    }
    EXPECT_NEAR(sum_n, gripped.force_n, 0.3 * gripped.force_n);
    EXPECT_EQ(afferent_controller_part(handle.controller, 3, &force_n, &sigma_n), AFFERENT_FAILED);
    EXPECT_NE(std::string(afferent_controller_error(handle.controller)).find("part must be below 3"),
              std::string::npos);
    EXPECT_EQ(afferent_controller_parts(ControllerHandle(scene).controller), 0U);
    EXPECT_EQ(afferent_controller_parts(nullptr), 0U);
}

TEST(CController, RefusesWhatCannotBeAndSaysWhy) {
    EXPECT_EQ(afferent_controller_open_text("gain { lambda_n: 0 }"), nullptr);
    EXPECT_NE(std::string(afferent_controller_error(nullptr)).find("lambda_n must be > 0"),
              std::string::npos);
    EXPECT_EQ(afferent_controller_open_file(nullptr), nullptr);
    const ControllerHandle handle(scene);
    const auto refused = [&](int result, const char* why) {
        EXPECT_EQ(result, AFFERENT_FAILED);
        EXPECT_NE(std::string(afferent_controller_error(handle.controller)).find(why), std::string::npos)
            << afferent_controller_error(handle.controller);
    };
    const afferent_event stranger{0, 3};
    refused(afferent_controller_observe(handle.controller, 0, 5, &stranger, 1), "address must be below 3");
    const afferent_event late{7, 0};
    refused(afferent_controller_observe(handle.controller, 0, 5, &late, 1),
            "time_ns must be within the span");
    refused(afferent_controller_observe(handle.controller, 5, 0, nullptr, 0),
            "end_ns must be not before begin_ns");
    EXPECT_EQ(afferent_controller_lose(handle.controller, 0, 10), AFFERENT_OK);
    refused(afferent_controller_lose(handle.controller, 5, 20),
            "begin_ns must be not before the end of the last span");
    refused(afferent_controller_set_state(handle.controller, 3), "state must be");
    refused(afferent_controller_receive(handle.controller, "x", 1), "the scene's link carries no packets");
    afferent_step step{};
    EXPECT_EQ(afferent_controller_step(handle.controller, 2'000'000, 2048, 2048, &step), AFFERENT_OK);
    refused(afferent_controller_step(handle.controller, 1'000'000, 2048, 2048, &step),
            "now_ns must be not before");
    EXPECT_EQ(afferent_controller_step(nullptr, 0, 0, 0, &step), AFFERENT_FAILED);
    afferent_controller_close(nullptr);
    afferent_snapshot_free(nullptr);
}

}  // namespace
