// Recorded scans, and images of forces laid over the skin.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numeric>

#include "afferent/nodes/image_on_skin.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

ScanSet scan_set(ScanSet::Head head, const std::vector<double>& times_and_values) {
    std::vector<std::byte> bytes(sizeof head + times_and_values.size() * sizeof(double));
    std::memcpy(bytes.data(), &head, sizeof head);
    std::memcpy(bytes.data() + sizeof head, times_and_values.data(),
                times_and_values.size() * sizeof(double));
    return value_or_throw(ScanSet::of(std::move(bytes)));
}

Plan plan_with_scans(const std::string& patches) {
    return make_plan(Scene::from_text(patches +
                                      " source { table { path: 'x.h5' column: 'force_n' } } record { "
                                      "force: false picture: false }"));
}

constexpr const char* three_elements = "patch { name: 'a' elements: 2 } patch { name: 'b' elements: 1 }";

// As a CSV table with the same columns has them.
TEST(RecordedScans, AreThoseOfATable) {
    const Plan plan = plan_with_scans(three_elements);
    const scene::Table table{.path = "x.h5", .column = {"force_n"}};
    const auto source = TableSource::of_scans(
        plan, table, scan_set({.scans = 2, .columns = 3}, {0.1, 0.2, 1, 2, 3, 4, 5, 6}));
    ASSERT_TRUE(source) << source.error().text;
    TableSource csv(plan, {.path = "x"});
    ASSERT_TRUE(csv.feed("time_s,a_n,b_n,c_n\n0.1,1,2,3\n0.2,4,5,6\n"));
    ASSERT_TRUE(csv.finish());
    std::size_t scans = 0;
    while (const auto due = csv.next()) {
        ASSERT_EQ(source.value()->next(), due);
        const auto expected = csv.take(0);
        const auto scan = source.value()->take(0);
        ASSERT_TRUE(expected && scan);
        EXPECT_EQ(scan->first, expected->first);
        EXPECT_EQ(std::vector<double>(scan->forces_n.begin(), scan->forces_n.end()),
                  std::vector<double>(expected->forces_n.begin(), expected->forces_n.end()));
        ++scans;
    }
    EXPECT_EQ(scans, 2 * 21U) << "each patch at 200 Hz";
    EXPECT_FALSE(source.value()->next());
}

TEST(RecordedScans, AreRefusedInWords) {
    const auto why = [](const std::string& patches, const std::string& column, const ScanSet& scans) {
        const Plan plan = plan_with_scans(patches);
        const auto source = TableSource::of_scans(plan, {.path = "x.h5", .column = {column}}, scans);
        return source ? std::string("accepted") : source.error().text;
    };
    const ScanSet two = scan_set({.scans = 1, .columns = 2}, {0, 1, 2});
    EXPECT_EQ(why(three_elements, "force_n", two),
              "x.h5: force_n has 2 values in a scan, and the scene has 3 elements");
    EXPECT_EQ(why(three_elements, "force", two), "x.h5: force must end in _n (newtons) or _counts");
    const ScanSet image = scan_set({.scans = 1, .rows = 1, .columns = 2, .is_image = 1}, {0, 1, 2});
    EXPECT_EQ(why(three_elements, "force_n", image),
              "x.h5: force_n is of images, and patch \"a\" has no outline to lay them over");
    EXPECT_EQ(why(three_elements, "run/raw_counts", image),
              "x.h5: run/raw_counts must end in _n: images are of newtons");
    const Plan plan = plan_with_scans(three_elements);
    const auto source = TableSource::of_scans(plan, {.path = "x.h5", .column = {"force_n"}},
                                              scan_set({.scans = 1, .columns = 3}, {0, 1, std::nan(""), 3}));
    ASSERT_TRUE(source) << source.error().text;
    EXPECT_FALSE(source.value()->next());
    ASSERT_TRUE(source.value()->error());
    EXPECT_EQ(source.value()->error()->text, "x.h5:1: the scan has a value that is no number");
    EXPECT_NO_THROW(Scene::from_text("source { table { path: 'x.h5' } }"))
        << "datasets that are columns need no name";
}

// Cells that tile the outlines share the pixels' forces without losing any, however fine either is.
TEST(ImageOnSkin, KeepsTheForce) {
    for (const auto& [rows, columns] :
         std::vector<std::pair<std::size_t, std::size_t>>{{1, 1}, {3, 7}, {40, 50}}) {
        const Plan plan =
            plan_with_scans("patch { name: 'a' outline { rectangle { width_mm: 12 height_mm: 8 } } }");
        const ReceptiveFields fields = image_on_skin(plan, rows, columns);
        std::vector<double> image(rows * columns);
        for (std::size_t i = 0; i < image.size(); ++i) image[i] = 1 + std::sin(static_cast<double>(i));
        double felt = 0;
        for (std::uint32_t i = 0; i < plan.elements; ++i) felt += fields.sum(i, image);
        const double sum = std::accumulate(image.begin(), image.end(), 0.0);
        EXPECT_NEAR(felt, sum, 1e-12 * sum);
    }
}

// The first row is at the top of the map, and patches lie where they are on it.
TEST(ImageOnSkin, LiesAcrossPatches) {
    const Plan plan = plan_with_scans(
        "every_patch { outline { rectangle { width_mm: 2 height_mm: 2 } pitch_mm: 2 } } "
        "patch { name: 'right' outline { centre { x_mm: 9 y_mm: 5 } } } patch { name: 'left' outline { "
        "centre { "
        "x_mm: 3 y_mm: 7 } } }");
    // From x = 2 to 10 and y = 4 to 8, in pixels of 2 mm.
    const ReceptiveFields fields = image_on_skin(plan, 2, 4);
    const std::vector<double> image{1, 2, 3, 4, 5, 6, 7, 8};
    EXPECT_NEAR(fields.sum(0, image), 8, 1e-12);
    EXPECT_NEAR(fields.sum(1, image), 1, 1e-12);
}

TEST(RecordedScans, MayBeImages) {
    const Plan plan = plan_with_scans(
        "patch { name: 'a' outline { rectangle { width_mm: 2 height_mm: 1 } } sensor { rate_hz: 10 } }");
    const auto source = TableSource::of_scans(
        plan, {.path = "x.h5", .column = {"force_n"}},
        scan_set({.scans = 2, .rows = 2, .columns = 1, .is_image = 1}, {0, 0.1, 1, 3, 2, 6}));
    ASSERT_TRUE(source) << source.error().text;
    for (const double each_n : {2.0, 4.0}) {
        ASSERT_TRUE(source.value()->next());
        const auto scan = source.value()->take(0);
        ASSERT_TRUE(scan);
        ASSERT_EQ(scan->forces_n.size(), 2U);
        for (const double force_n : scan->forces_n) EXPECT_NEAR(force_n, each_n, 1e-12);
    }
}

}  // namespace
}  // namespace afferent
