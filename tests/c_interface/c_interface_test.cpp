#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "afferent/scene/afferent.h"

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
    EXPECT_NE(std::string(afferent_error(nullptr)).find("elements must be > 0"), std::string::npos);
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
        "patch { name: 'a' elements: 1 encoder { sustained { gain_mv_per_n: 1 bias_mv: 1e9 } } } "
        "runtime { spikes_per_window: 10 }");
    EXPECT_LT(afferent_advance(handle.coprocessor, 1'000'000'000, nullptr, 0), 0);
    EXPECT_NE(std::string(afferent_error(handle.coprocessor)).find("address 0"), std::string::npos);
}

}  // namespace
