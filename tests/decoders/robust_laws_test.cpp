// The laws that decoders keep where what they are told is not true, or where their sensors cannot tell.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string_view>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/grip_decoder.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

enum class Law { scaling, full_scale, unheard, opposite, search };

// Decoders that do not keep a law, and why. Those that count spikes or solve intervals take what they are
// told for true and do not claim to know when it is not.
struct Exception {
    Law law;
    std::string_view decoder;
    const char* reason;
};
constexpr Exception exceptions[]{
    {Law::unheard, "sliding_window", "it counts spikes, and sigma is that of counting"},
    {Law::unheard, "exponential", "it counts spikes, and sigma is that of counting"},
    {Law::unheard, "interval", "it counts spikes, and sigma is that of counting"},
    {Law::search, "sliding_window", "it claims nothing of what it is not told"},
    {Law::search, "exponential", "it claims nothing of what it is not told"},
    {Law::search, "interval", "it claims nothing of what it is not told"},
    {Law::search, "inversion", "it claims nothing of what it is not told"},
};

template <class D>
constexpr std::string_view name_of = "";
template <>
constexpr std::string_view name_of<SlidingWindow> = "sliding_window";
template <>
constexpr std::string_view name_of<Exponential> = "exponential";
template <>
constexpr std::string_view name_of<InverseInterval> = "interval";
template <>
constexpr std::string_view name_of<Inversion> = "inversion";
template <>
constexpr std::string_view name_of<Filter> = "filter";

// Why it is excepted; nothing where it is not.
template <class D>
const char* exception_of(Law law) {
    for (const Exception& each : exceptions)
        if (each.law == law && each.decoder == name_of<D>) return each.reason;
    return nullptr;
}

// Three fingers of three elements, whose neurons adapt over half a second.
const std::vector<double> shares{0.2, 0.15, 0.05, 0.15, 0.1, 0.05, 0.15, 0.1, 0.05};
constexpr double full_scale_n = 25;

DecodedAfferents three_fingers() {
    const LifParameters neuron{.tau_g_ms = 500, .delta_g = 0.03};
    DecodedAfferents told{.addresses = shares.size(), .largest_grip_n = full_scale_n};
    for (Address address = 0; address < shares.size(); ++address)
        told.add(address,
                 {.neuron = neuron,
                  .drive_mv_per_n = 18 * shares[address],
                  .bias_mv = neuron.rheobase_mv() - 0.6,
                  .full_scale_n = full_scale_n},
                 shares[address], address / 3);
    return told;
}

// A grip as it is: where afferents differ from what is told, and the force.
struct Grip {
    std::vector<double> gain = std::vector<double>(shares.size(), 1);  // 0: dead
    double delta_g = 1;                                                // in times of what is told
    double hold_n = 10;
    double contact_s = 0.5;
    bool trembles = false;

    static constexpr Duration end = 3500ms;
    // Rises within 0.2 s of the contact and holds.
    double force_n(double time_s) const {
        const double tremor = trembles ? 0.1 * std::sin(6 * std::numbers::pi * time_s) : 0;
        return hold_n * std::clamp((time_s - contact_s) / 0.2, 0.0, 1.0) * (1 + tremor);
    }
    // Once the neurons have adapted.
    static constexpr bool is_held(Duration time) { return time >= 2s; }
};

std::vector<Event> events_of(const DecodedAfferents& told, const Grip& grip) {
    std::vector<Event> events;
    for (const DecodedAfferents::Afferent& each : told.afferents) {
        if (grip.gain[each.address] == 0) continue;
        DecodedAfferents::Group group = told.groups[each.group];
        std::get<LifParameters>(group.neuron).delta_g *= grip.delta_g;
        group.drive_mv_per_n *= grip.gain[each.address];
        const auto own = fired(
            group, Grip::end,
            [&](double time_s) { return std::min(grip.force_n(time_s), group.full_scale_n); }, each.address);
        events.insert(events.end(), own.begin(), own.end());
    }
    std::sort(events.begin(), events.end());
    return events;
}

struct Followed {
    Duration time;
    double true_n;
    Estimate estimate;

    double error_n() const { return estimate.force_n - true_n; }
    double upper_n() const { return estimate.force_n + 2 * estimate.sigma_n; }
};

// In packets of 5 ms, delivered at once.
template <class D>
std::vector<Followed> follow(const DecodedAfferents& told, const std::vector<Event>& events,
                             const Grip& grip) {
    D decoder({}, told);
    std::vector<Followed> followed;
    auto next = events.begin();
    for (Duration begin = 0ms; begin < Grip::end; begin += 5ms) {
        const auto first = next;
        while (next != events.end() && next->time < at(begin + 5ms)) ++next;
        decoder.observe(at(begin), at(begin + 5ms), {first, next});
        followed.push_back(
            {begin + 5ms, grip.force_n(seconds(begin + 5ms)), decoder.estimate(at(begin + 5ms))});
    }
    return followed;
}

double held_error_n(const std::vector<Followed>& followed) {
    double sum_n = 0;
    int count = 0;
    for (const Followed& each : followed) {
        if (!Grip::is_held(each.time)) continue;
        sum_n += each.error_n();
        ++count;
    }
    return sum_n / count;
}

// The part of the hold for which the force is further from the estimate than so many sigma and than a
// twentieth of the force.
double part_beyond(const std::vector<Followed>& followed, double sigmas) {
    int beyond = 0, count = 0;
    for (const Followed& each : followed) {
        if (!Grip::is_held(each.time)) continue;
        beyond += std::abs(each.error_n()) > std::max(sigmas * each.estimate.sigma_n, each.true_n / 20);
        ++count;
    }
    return static_cast<double>(beyond) / count;
}

template <class D>
class RobustLaws : public testing::Test {
  protected:
    const DecodedAfferents told = three_fingers();
};

template <class... D>
testing::Types<D...> types_of(DecoderList<D...>);
using Types = decltype(types_of(Decoders()));
TYPED_TEST_SUITE(RobustLaws, Types);

#define EXCEPT_IN(law)                                           \
    if (const char* const reason = exception_of<TypeParam>(law)) \
    GTEST_SKIP() << name_of<TypeParam> << ": " << reason

// The same spikes of sensors that are so many times as stiff are so many times the force.
TYPED_TEST(RobustLaws, ScalingAllForcesScalesTheEstimateAndSigma) {
    EXCEPT_IN(Law::scaling);
    const Grip grip;
    const auto events = events_of(this->told, grip);
    const auto plain = follow<TypeParam>(this->told, events, grip);
    for (const double scale : {0.01, 0.1, 10.0}) {
        DecodedAfferents scaled = this->told;
        scaled.largest_grip_n *= scale;
        scaled.uncertainty.offset_n *= scale;
        for (DecodedAfferents::Group& group : scaled.groups) {
            group.drive_mv_per_n /= scale;
            group.full_scale_n *= scale;
            group.noise_n *= scale;
        }
        const auto found = follow<TypeParam>(scaled, events, grip);
        for (std::size_t k = 0; k < plain.size(); ++k) {
            // Rates are solved for to nine digits, and sigma is a difference of forces.
            const double tolerance_n = 1e-6 * full_scale_n;
            ASSERT_NEAR(found[k].estimate.force_n / scale, plain[k].estimate.force_n, tolerance_n);
            ASSERT_NEAR(found[k].estimate.sigma_n / scale, plain[k].estimate.sigma_n, tolerance_n);
        }
    }
}

// All sensors read 25 N: the force may be larger, and is not known to be less.
TYPED_TEST(RobustLaws, ASensorAtFullScaleNeverLowersTheUpperBound) {
    EXCEPT_IN(Law::full_scale);
    for (const double hold_n : {26.0, 40.0}) {
        const Grip grip{.hold_n = hold_n};
        for (const Followed& each : follow<TypeParam>(this->told, events_of(this->told, grip), grip)) {
            if (!Grip::is_held(each.time)) continue;
            // Counted spikes ripple by as much.
            ASSERT_GE(each.upper_n(), 0.95 * full_scale_n) << seconds(each.time) << " s under " << hold_n;
        }
    }
}

// Fewer afferents, as the decoder is told: it knows less, and sigma covers it.
TYPED_TEST(RobustLaws, RemovingAnyAfferentsKeepsTheTruthWithinThreeSigma) {
    const Grip grip;
    std::mt19937 random(5);
    for (int draw = 0; draw < 6; ++draw) {
        DecodedAfferents fewer = this->told;
        while (fewer.afferents.size() > 1 + random() % 3)
            fewer.afferents.erase(fewer.afferents.begin() +
                                  static_cast<std::ptrdiff_t>(random() % fewer.afferents.size()));
        const auto followed = follow<TypeParam>(fewer, events_of(fewer, grip), grip);
        EXPECT_LT(part_beyond(followed, 3), 0.1) << "draw " << draw;
    }
}

// Afferents that are dead without the decoder being told: those with the largest shares, and others at
// random; at a contact, and in a grip that began before the decoder.
TYPED_TEST(RobustLaws, UnheardAfferentsKeepTheTruthWithinThreeSigma) {
    EXCEPT_IN(Law::unheard);
    const std::vector<std::size_t> by_share{0, 1, 3, 6, 4, 7, 2, 5, 8};
    std::mt19937 random(6);
    for (unsigned dead = 1; dead <= 6; ++dead)
        for (const double contact_s : {0.5, -0.2})
            for (const bool largest : {true, false}) {
                Grip grip{.hold_n = 20, .contact_s = contact_s, .trembles = true};
                for (unsigned i = 0; i < dead; ++i)
                    grip.gain[largest ? by_share[i] : random() % shares.size()] = 0;
                const auto followed = follow<TypeParam>(this->told, events_of(this->told, grip), grip);
                EXPECT_LT(part_beyond(followed, 3), 0.1)
                    << dead << (largest ? " largest" : "") << ", contact at " << contact_s << " s";
            }
}

TYPED_TEST(RobustLaws, WrongStatementsInOppositeDirectionsGiveErrorsOfOppositeSign) {
    EXCEPT_IN(Law::opposite);
    const Grip as_told;
    Grip weak, strong;
    weak.gain.assign(shares.size(), 0.9);
    strong.gain.assign(shares.size(), 1.1);
    Grip tiring, fresh;
    tiring.delta_g = 1.2;
    fresh.delta_g = 0.8;
    const auto error_n = [&](const Grip& grip) {
        return held_error_n(follow<TypeParam>(this->told, events_of(this->told, grip), grip));
    };
    const double plain_n = error_n(as_told);
    EXPECT_LT(error_n(weak), plain_n);
    EXPECT_GT(error_n(strong), plain_n);
    EXPECT_LT(error_n(tiring), plain_n);
    EXPECT_GT(error_n(fresh), plain_n);
}

// Errors as large as they are stated to be, and a finger that may not touch: is the force ever far from the
// estimate while sigma is small? The bar of the filter: beyond three sigma for at most 3 % of the time over
// all draws, and never for more than a third of one of them.
TYPED_TEST(RobustLaws, ARandomSearchFindsNoCertainEstimateThatIsFarFromTheTruth) {
    EXCEPT_IN(Law::search);
    constexpr int draws = 60;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> up_to_one;
    // An error beyond two of its standard deviations would prove nothing.
    std::normal_distribution<double> gaussian;
    const auto normal = [&] { return std::clamp(gaussian(random), -2.0, 2.0); };
    double all = 0;
    for (int draw = 0; draw < draws; ++draw) {
        DecodedAfferents stated = this->told;
        stated.uncertainty = {.gain = 0.1 * up_to_one(random),
                              .common_gain = 0.1 * up_to_one(random),
                              .adaptation = 0.2 * up_to_one(random)};
        Grip grip{.trembles = draw % 2 == 0};
        grip.hold_n = 2 * std::pow(10, up_to_one(random));
        grip.delta_g = std::max(0.3, 1 + stated.uncertainty.adaptation * normal());
        const double common = 1 + stated.uncertainty.common_gain * normal();
        for (double& gain : grip.gain) gain = common * (1 + stated.uncertainty.gain * normal());
        if (random() % 4 == 0)
            for (std::size_t first = 3 * (random() % 3), i = first; i < first + 3; ++i) grip.gain[i] = 0;
        const double beyond = part_beyond(follow<TypeParam>(stated, events_of(stated, grip), grip), 3);
        EXPECT_LT(beyond, 1.0 / 3) << "draw " << draw << ", " << grip.hold_n << " N";
        all += beyond / draws;
    }
    EXPECT_LT(all, 0.03);
}

}  // namespace
}  // namespace afferent
