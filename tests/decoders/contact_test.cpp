// The contact that afferents of a patch of skin tell of, against that of a sphere (Hertz).
#include "afferent/decoders/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "afferent/decoders/readouts.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/summary.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

constexpr double field_mm2 = 0.25;
constexpr double unit_n_per_mm2 = 0.002;

// Fields a millimetre apart on 8 × 8 mm of skin, whose elements are half a millimetre wide.
ContactReadout::Parameters skin() {
    ContactReadout::Parameters parameters{.addresses = 81, .patch = {3}, .element_mm2 = 0.25};
    DecodedAfferents::Group group = group_with(2);
    group.full_scale_n = 60;
    for (Address address = 0; address < 81; ++address)
        parameters.afferents.push_back(
            {address, group, unit_n_per_mm2, {address % 9 - 4.0, address / 9 - 4.0, field_mm2}});
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 17; ++x) parameters.elements.push_back({x / 2.0 - 4, y / 2.0 - 4, 0.25 / 12});
    return parameters;
}

// Hertz's, of a sphere: P √(1 − (d/radius)²)
struct Press {
    double peak_n_per_mm2, x_mm, y_mm, radius_mm;

    double force_n() const { return area_mm2() * 2 / 3 * peak_n_per_mm2; }
    double area_mm2() const { return std::numbers::pi * radius_mm * radius_mm; }
    // The mean under a Gaussian, as a sum over squares that are far smaller than either.
    double read_by(const SkinField& field) const {
        constexpr double step_mm = 0.1;
        double sum = 0;
        for (double y = -radius_mm; y < radius_mm; y += step_mm)
            for (double x = -radius_mm; x < radius_mm; x += step_mm) {
                const double pressure = std::sqrt(std::max(0.0, 1 - (x * x + y * y) / radius_mm / radius_mm));
                const double square = std::pow(x_mm + x - field.x_mm, 2) + std::pow(y_mm + y - field.y_mm, 2);
                sum += pressure * std::exp(-square / (2 * field.variance_mm2)) * step_mm * step_mm;
            }
        return peak_n_per_mm2 * sum / (2 * std::numbers::pi * field.variance_mm2);
    }
};

// What the afferents fire where pressure_of(field) returns the pressure on that field, in N/mm², as a
// function of the time in seconds.
template <class PressureOf>
std::vector<Event> fired_by(const ContactReadout::Parameters& skin, Duration end, PressureOf pressure_of) {
    std::vector<Event> events;
    for (const auto& [address, group, unit, field] : skin.afferents) {
        const auto felt = [pressure = pressure_of(field), unit = unit](double time_s) {
            return pressure(time_s) / unit;
        };
        const auto train = fired(group, end, felt, address);
        events.insert(events.end(), train.begin(), train.end());
    }
    std::sort(events.begin(), events.end());
    return events;
}

// One that is pressed on for a time.
auto held(double n_per_mm2, Duration begin, Duration release) {
    return
        [=](double time_s) { return time_s >= seconds(begin) && time_s < seconds(release) ? n_per_mm2 : 0; };
}

std::vector<Event> fired_under(const ContactReadout::Parameters& skin, const Press& press, Duration begin,
                               Duration release, Duration end) {
    return fired_by(skin, end,
                    [&](const SkinField& field) { return held(press.read_by(field), begin, release); });
}

// The contacts of packets of 5 ms.
std::vector<PatchContact> contacts(ContactReadout& readout, const std::vector<Event>& events, Duration begin,
                                   Duration end) {
    std::vector<PatchContact> all;
    auto first = std::lower_bound(events.begin(), events.end(), Event{at(begin), 0});
    for (Duration time = begin; time < end; time += 5ms) {
        const auto last = std::lower_bound(first, events.end(), Event{at(time + 5ms), 0});
        readout.observe(at(time), at(time + 5ms), {first, last});
        for (const PatchContact& contact : readout.step(at(time + 5ms))) all.push_back(contact);
        first = last;
    }
    return all;
}

TEST(ContactEstimate, BeginsAsNoContact) {
    EXPECT_EQ(ContactEstimate(), (ContactEstimate{0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(ContactReadout, TellsForceCentreAndAreaOfAPress) {
    const auto parameters = skin();
    for (const Press& press : {Press{0.02, 0.4, -0.3, 2}, Press{0.05, -1.2, 0.9, 1.6}}) {
        ContactReadout readout(parameters);
        const auto found = contacts(readout, fired_under(parameters, press, 100ms, 1s, 600ms), 0ms, 600ms);
        ASSERT_EQ(found.size(), 61U) << "one each 10 ms, and one at the start";
        std::size_t inside = 0;
        for (const auto& [time, patch, contact, estimate] : found) {
            EXPECT_EQ(patch.value, 3U);
            EXPECT_EQ(contact, 0U);
            // Until silence has told that nothing touches.
            if (time >= at(20ms) && time <= at(100ms)) {
                EXPECT_EQ(estimate.afferents, 0U);
                EXPECT_EQ(estimate.force_n, 0);
            }
            if (time < at(350ms)) continue;
            // A field that a hundredth of the pressure reaches is silent: its threshold is 0.3 units.
            EXPECT_GT(estimate.afferents, 10U);
            EXPECT_LT(estimate.afferents, 60U);
            EXPECT_FALSE(estimate.slides);
            EXPECT_NEAR(estimate.force_n, press.force_n(), 0.05 * press.force_n());
            EXPECT_NEAR(estimate.x_mm, press.x_mm, 0.05);
            EXPECT_NEAR(estimate.y_mm, press.y_mm, 0.05);
            EXPECT_NEAR(estimate.area_mm2, press.area_mm2(), 0.1 * press.area_mm2());
            inside += std::abs(estimate.force_n - press.force_n()) < 2 * estimate.force_sigma_n &&
                      std::abs(estimate.x_mm - press.x_mm) < 2 * estimate.x_sigma_mm &&
                      std::abs(estimate.y_mm - press.y_mm) < 2 * estimate.y_sigma_mm &&
                      std::abs(estimate.area_mm2 - press.area_mm2()) < 2 * estimate.area_sigma_mm2;
        }
        EXPECT_EQ(inside, 26U) << "of two sigma, which hold what another shape would cost";
    }
}

// A sphere that begins at one side of the skin and slides to the other.
TEST(ContactReadout, TellsWhereAContactIsWhileItSlides) {
    const auto parameters = skin();
    const Press press{0.05, 0, 0, 1.6};
    for (const auto& [speed_x, speed_y] : {std::pair{12.0, 0.0}, {-8.0, 5.0}}) {
        const auto place = [](double speed, double time_s) { return speed * (time_s - 0.3); };
        constexpr double step_mm = 0.05;
        std::vector<double> by_distance;
        for (double mm = 0; mm < 12; mm += step_mm) by_distance.push_back(press.read_by({mm, 0, field_mm2}));
        const auto events = fired_by(parameters, 500ms, [&](const SkinField& field) {
            return [&](double time_s) {
                const double mm =
                    std::hypot(field.x_mm - place(speed_x, time_s), field.y_mm - place(speed_y, time_s)) /
                    step_mm;
                const auto at = static_cast<std::size_t>(mm);
                return std::lerp(by_distance[at], by_distance[at + 1], mm - static_cast<double>(at));
            };
        });
        ContactReadout readout(parameters);
        int told = 0, inside = 0;
        for (const auto& [time, patch, contact, estimate] : contacts(readout, events, 0ms, 500ms)) {
            if (time < at(200ms)) continue;
            ++told;
            ASSERT_TRUE(estimate.slides) << seconds(time);
            const double x_mm = place(speed_x, seconds(time));
            const double y_mm = place(speed_y, seconds(time));
            // Within a field and what it slides in the 5 ms in which a neuron fires.
            EXPECT_NEAR(estimate.x_mm, x_mm, 0.3) << seconds(time);
            EXPECT_NEAR(estimate.y_mm, y_mm, 0.3) << seconds(time);
            EXPECT_NEAR(estimate.force_n, press.force_n(), 0.25 * press.force_n()) << seconds(time);
            inside +=
                std::abs(estimate.velocity_x_mm_per_s - speed_x) < 2 * estimate.velocity_x_sigma_mm_per_s &&
                std::abs(estimate.velocity_y_mm_per_s - speed_y) < 2 * estimate.velocity_y_sigma_mm_per_s;
            EXPECT_NEAR(estimate.velocity_x_mm_per_s, speed_x, 4) << seconds(time);
            EXPECT_NEAR(estimate.velocity_y_mm_per_s, speed_y, 4) << seconds(time);
        }
        EXPECT_GE(inside, 0.8 * told) << told;
    }
}

// Two spheres 4 mm apart: the sum of their pressures.
TEST(ContactReadout, TellsTwoContactsApart) {
    const auto parameters = skin();
    const Press presses[]{{0.05, -2, -0.3, 1.3}, {0.03, 2, 0.4, 1.5}};
    const auto events = fired_by(parameters, 600ms, [&](const SkinField& field) {
        return held(presses[0].read_by(field) + presses[1].read_by(field), 100ms, 1s);
    });
    ContactReadout readout(parameters);
    for (const auto& [time, patch, contact, estimate] : contacts(readout, events, 0ms, 600ms)) {
        if (time < at(350ms)) continue;
        ASSERT_LT(contact, 2U);
        const Press& press = presses[contact];  // the first has the larger force
        EXPECT_GT(estimate.afferents, 3U);
        EXPECT_NEAR(estimate.force_n, press.force_n(), 0.1 * press.force_n());
        EXPECT_NEAR(estimate.x_mm, press.x_mm, 0.1);
        EXPECT_NEAR(estimate.y_mm, press.y_mm, 0.1);
    }
    EXPECT_EQ(readout.contacts(at(600ms)).size(), 2U);
}

TEST(ContactReadout, TellsOfARelease) {
    const auto parameters = skin();
    const auto events = fired_under(parameters, {0.02, 0.4, -0.3, 2}, 0ms, 400ms, 1s);
    ContactReadout readout(parameters);
    const auto found = contacts(readout, events, 0ms, 1s);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.back().estimate, ContactEstimate());
}

// A pressure that is the same on all of a disc fits no sphere, and moving it makes that no better.
TEST(ContactReadout, TakesAContactOfAnotherShapeForOneThatStands) {
    const auto parameters = skin();
    const auto events = fired_by(parameters, 600ms, [](const SkinField& field) {
        const double mm = std::hypot(field.x_mm - 0.4, field.y_mm + 0.3);
        return held(0.05 * std::erfc((mm - 2) / std::sqrt(2 * field_mm2)) / 2, 100ms, 1s);
    });
    ContactReadout readout(parameters);
    for (const auto& [time, patch, contact, estimate] : contacts(readout, events, 0ms, 600ms)) {
        if (time < at(250ms)) continue;
        EXPECT_FALSE(estimate.slides) << seconds(time);
    }
}

TEST(Readouts, TellOfAReleaseBySilenceThatIsPresumed) {
    const auto parameters = skin();
    const auto events = fired_under(parameters, {0.02, 0.4, -0.3, 2}, 0ms, 1s, 400ms);
    Readouts readouts({parameters});
    readouts.observe(at(0ms), at(400ms), events);
    const auto afferents_at = [&](TimePoint time) {
        std::vector<PatchReadout> told;
        readouts.step(time, told);
        return std::get<PatchContact>(told.at(0)).estimate.afferents;
    };
    EXPECT_GT(afferents_at(at(400ms)), 10U);
    // Half a second after its last spike no afferent counts as touched.
    readouts.presume_silence(at(900ms));
    EXPECT_EQ(afferents_at(at(900ms)), 0U);
}

TEST(ContactReadout, KnowsLessWhereSpansAreLost) {
    const auto parameters = skin();
    const Press press{0.02, 0.4, -0.3, 2};
    const auto events = fired_under(parameters, press, 0ms, 1s, 600ms);
    ContactReadout readout(parameters);
    contacts(readout, events, 0ms, 500ms);
    const ContactEstimate not_told_yet = readout.contacts(at(560ms))[0].estimate;
    readout.lose(at(500ms), at(560ms));
    const ContactEstimate after = readout.contacts(at(560ms))[0].estimate;
    EXPECT_GT(after.force_sigma_n, not_told_yet.force_sigma_n);
    EXPECT_LT(std::abs(after.force_n - press.force_n()), 2 * after.force_sigma_n);
}

TEST(ContactReadout, GoesOnFromASnapshotAndFromAGap) {
    const auto parameters = skin();
    const auto events = fired_under(parameters, {0.02, 0.4, -0.3, 2}, 100ms, 1s, 500ms);
    ContactReadout one(parameters), other(parameters), resumed(parameters);
    contacts(one, events, 0ms, 303ms);
    other.resume(one.snapshot());
    EXPECT_TRUE(other.step(at(307ms)).empty()) << "that of 300 ms has been told";
    EXPECT_EQ(contacts(other, events, 305ms, 500ms), contacts(one, events, 305ms, 500ms));
    resumed.resume_after(at(300ms), at(300ms));
    EXPECT_TRUE(resumed.step(at(309ms)).empty());
    EXPECT_EQ(resumed.step(at(310ms)).size(), 1U);
    other.restart(scene_start);
    EXPECT_EQ(other.contacts(scene_start)[0].estimate.afferents, 0U);
}

TEST(ContactReadout, RefusesToTellNothing) {
    auto never = skin();
    never.interval = 0ms;
    EXPECT_THROW((void)ContactReadout(never), ParameterError);
    auto nowhere = skin();
    nowhere.elements.clear();
    EXPECT_THROW((void)ContactReadout(nowhere), ParameterError);
}

// Elements at full scale may feel as much again as they say.
TEST(ContactReadout, IsLessSureOfAForceThatReachesFullScale) {
    const Press press{0.05, 0.4, -0.3, 2};
    const auto sigma_n = [&](double full_scale_n_per_mm2) {
        auto parameters = skin();
        for (auto& afferent : parameters.afferents)
            afferent.group.full_scale_n = full_scale_n_per_mm2 / unit_n_per_mm2;
        ContactReadout readout(parameters);
        return contacts(readout, fired_under(parameters, press, 100ms, 1s, 600ms), 0ms, 600ms)
            .back()
            .estimate.force_sigma_n;
    };
    const double far_below_n = sigma_n(0.5);
    EXPECT_LT(far_below_n, 0.1 * press.force_n());
    EXPECT_GT(sigma_n(0.052), 3 * far_below_n) << "0.05 is nearly that";
}

TEST(ContactReadout, SumsUpARunByItsLargestForce) {
    ContactReadout::Totals totals;
    for (const double force_n : {0.5, 2.0, 1.0}) {
        PatchContact contact;
        contact.estimate.force_n = force_n;
        totals.add(contact);
    }
    Summary summary;
    totals.add_to(summary, "thumb");
    EXPECT_EQ(summary["largest_contact_force_n"]["thumb"].number(), 2.0);
}

}  // namespace
}  // namespace afferent
