// The laws of every decoder of the list, and of the one that stands for any of them.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/grip_decoder.hpp"
#include "afferent/decoders/readouts.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/counted_allocations.hpp"
#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

// Pooled and per neuron.
template <class D>
struct Variants {
    static std::vector<typename D::Parameters> all() {
        typename D::Parameters pooled, per_neuron;
        if constexpr (requires { pooled.pooling; }) per_neuron.pooling = Pooling::per_neuron;
        return {pooled, per_neuron};
    }
};

template <class... D>
std::vector<DecoderParameters> variants_of_all(DecoderList<D...>) {
    std::vector<DecoderParameters> all;
    const auto append = [&](const auto& some) { all.insert(all.end(), some.begin(), some.end()); };
    (append(Variants<D>::all()), ...);
    return all;
}

template <>
struct Variants<GripDecoder> {
    static std::vector<DecoderParameters> all() { return variants_of_all(Decoders()); }
};

template <class D>
class DecoderLaws : public testing::Test {
  protected:
    const DecodedAfferents afferents = fingertips();
    const std::vector<typename D::Parameters> variants = Variants<D>::all();
};

// The filter of sensors whose samples are late, and which predicts the force of now.
class LateFilter : public Filter {
  public:
    LateFilter(const Parameters& parameters, DecodedAfferents afferents)
        : Filter(parameters, late(std::move(afferents))) {}

  private:
    static DecodedAfferents late(DecodedAfferents afferents) {
        afferents.delay = 20ms;
        return afferents;
    }
};

template <class... D>
testing::Types<D..., LateFilter, GripDecoder> types_of(DecoderList<D...>);
using Types = decltype(types_of(Decoders()));
TYPED_TEST_SUITE(DecoderLaws, Types);

TYPED_TEST(DecoderLaws, ASnapshotContinuesBitForBit) {
    for (const auto& parameters : this->variants) {
        TypeParam decoder(parameters, this->afferents);
        TypeParam other(parameters, this->afferents);
        for (unsigned seed = 0; seed < 20; ++seed) {
            const auto stream = random_stream(seed, 200, this->afferents.addresses);
            const std::size_t middle = 1 + 9 * seed;
            decoder.restart(scene_start);
            for (std::size_t i = 0; i < stream.size(); ++i) {
                // The other decoder goes on from whatever it was doing.
                if (i == middle) {
                    other.resume(decoder.snapshot());
                    ASSERT_EQ(other.snapshot(), decoder.snapshot()) << "seed " << seed;
                }
                const Estimate estimate = take(decoder, stream[i]);
                if (i < middle) continue;
                ASSERT_EQ(take(other, stream[i]), estimate) << "seed " << seed << ", step " << i;
                ASSERT_EQ(other.heard_until(), decoder.heard_until());
            }
            EXPECT_EQ(other.snapshot(), decoder.snapshot());
        }
    }
}

TYPED_TEST(DecoderLaws, ARestartForgetsEverything) {
    const auto stream = random_stream(7, 100, this->afferents.addresses);
    for (const auto& parameters : this->variants) {
        TypeParam used(parameters, this->afferents);
        for (const Step& step : stream) take(used, step);
        TypeParam fresh(parameters, this->afferents);
        used.restart(scene_start);
        EXPECT_EQ(used.snapshot(), fresh.snapshot()) << "a decoder starts at the scene's start";
        used.restart(at(30ms));
        fresh.restart(at(30ms));
        for (const Step& step : stream) {
            if (step.begin < at(30ms)) continue;
            ASSERT_EQ(take(used, step), take(fresh, step));
        }
    }
}

TYPED_TEST(DecoderLaws, WhereNothingIsKnownTheLastEstimateStandsAndSigmaIsTheWholeRange) {
    const auto stream = random_stream(3, 100, this->afferents.addresses);
    for (const auto& parameters : this->variants) {
        TypeParam decoder(parameters, this->afferents);
        EXPECT_EQ(decoder.estimate(scene_start),
                  (Estimate{.sigma_n = this->afferents.largest_grip_n, .doubt = Doubt::unknown}));
        Estimate before;
        for (const Step& step : stream) before = take(decoder, step);
        ASSERT_GT(before.force_n, 0);
        for (const Duration later : {10s, 1000s}) {
            const Estimate after = decoder.estimate(stream.back().now + later);
            EXPECT_EQ(after.force_n, before.force_n);
            EXPECT_EQ(after.rate_hz, before.rate_hz);
            EXPECT_EQ(after.sigma_n, this->afferents.largest_grip_n);
            EXPECT_EQ(after.doubt, Doubt::unknown);
        }
    }
}

TYPED_TEST(DecoderLaws, ContinuesAfterAnEstimateWithoutItsHistory) {
    const Estimate last{3, 0.5, 40};
    for (const auto& parameters : this->variants) {
        TypeParam decoder(parameters, this->afferents);
        decoder.resume_after(at(100ms), at(95ms), last);
        EXPECT_EQ(decoder.heard_until(), at(95ms));
        EXPECT_EQ(decoder.estimate(at(100ms)).force_n, last.force_n);
        EXPECT_EQ(decoder.estimate(at(100ms)).sigma_n, this->afferents.largest_grip_n);
        // Silent from the start on: it joins the span heard before, so nothing is lost.
        decoder.observe(at(95ms), at(600ms), {});
        EXPECT_EQ(decoder.estimate(at(600ms)).force_n, 0);

        TypeParam fresh(parameters, this->afferents);
        fresh.restart(at(100ms));
        fresh.observe(at(100ms), at(600ms), {});
        EXPECT_EQ(decoder.estimate(at(600ms)), fresh.estimate(at(600ms)));
    }
}

TYPED_TEST(DecoderLaws, EventsOfOtherAddressesDoNotCount) {
    for (const auto& parameters : this->variants) {
        TypeParam decoder(parameters, this->afferents);
        decoder.observe(scene_start, at(1s), regular_train(2, 0ms, 1ms, 1s));
        EXPECT_EQ(decoder.estimate(at(1s)).force_n, 0);
        EXPECT_EQ(decoder.estimate(at(1s)).rate_hz, 0);
    }
}

TYPED_TEST(DecoderLaws, SilenceIsAMeasurement) {
    for (const auto& parameters : this->variants) {
        TypeParam silent(parameters, this->afferents);
        silent.observe(scene_start, at(1s), {});
        const Estimate estimate = silent.estimate(at(1s));
        EXPECT_EQ(estimate.force_n, 0);
        EXPECT_LT(estimate.sigma_n, this->afferents.largest_grip_n / 4);
    }
}

// A new session in the middle of a grip, at every phase of an interval. Afferents that are alike fire
// together: a window that is known for a few milliseconds holds a spike of each or none, which would be 27 N
// or nothing.
TYPED_TEST(DecoderLaws, ClaimsNoMoreThanIsKnownAfterAStartInTheMiddleOfAHold) {
    constexpr Address count = 9;
    const DecodedAfferents::Group group = group_with(2);
    DecodedAfferents alike{.addresses = count, .largest_grip_n = 27};
    for (Address address = 0; address < count; ++address) alike.add(address, group, 1.0 / count);
    for (const double held_n : {3.0, 8.0, 15.0}) {
        std::vector<Event> events;
        for (const Event& event : fired(group, 1150ms, [&](double) { return held_n; }))
            for (Address address = 0; address < count; ++address) events.push_back({event.time, address});
        for (const auto& parameters : this->variants) {
            TypeParam decoder(parameters, alike);
            int estimates = 0, outside = 0;
            for (Duration start = 1s; start < 1030ms; start += 1ms) {
                decoder.restart(at(start));
                auto next = std::lower_bound(events.begin(), events.end(), Event{at(start), 0});
                for (Duration known = 1ms; known <= 100ms; known += 1ms) {
                    const auto first = next;
                    while (next != events.end() && next->time < at(start + known)) ++next;
                    decoder.observe(at(start + known - 1ms), at(start + known), std::span(first, next));
                    const Estimate estimate = decoder.estimate(at(start + known));
                    const double error_n = std::abs(estimate.force_n - held_n);
                    ASSERT_LE(error_n, 3 * estimate.sigma_n)
                        << held_n << " N, " << seconds(start) << " s, after " << seconds(known) << " s";
                    ++estimates;
                    outside += error_n > 2 * estimate.sigma_n;
                    if (known < 20ms && estimate.force_n < held_n / 2) {
                        ASSERT_EQ(estimate.doubt, Doubt::slow);
                    }
                }
            }
            EXPECT_LE(outside, 0.05 * estimates) << "of a Gaussian within two sigma, at " << held_n << " N";
        }
    }
}

TYPED_TEST(DecoderLaws, PresumedSilenceCountsUntilItTurnsOutToBeLost) {
    for (const auto& parameters : this->variants) {
        // The silent addresses are at rest by then.
        TypeParam presuming(parameters, this->afferents);
        TypeParam observing(parameters, this->afferents);
        TypeParam losing(parameters, this->afferents);
        const auto train = regular_train(0, 5ms, 10ms, 1500ms);
        for (auto* decoder : {&presuming, &observing, &losing})
            decoder->observe(scene_start, at(1500ms), train);
        const double before_n = losing.estimate(at(1500ms)).sigma_n;
        presuming.presume_silence(at(1520ms));
        observing.observe(at(1500ms), at(1520ms), {});
        losing.lose(at(1500ms), at(1520ms));
        EXPECT_EQ(presuming.estimate(at(1520ms)), observing.estimate(at(1520ms)));
        EXPECT_GT(losing.estimate(at(1520ms)).sigma_n, before_n);
        presuming.lose(at(1500ms), at(1520ms));
        EXPECT_EQ(presuming.estimate(at(1520ms)), losing.estimate(at(1520ms)));
    }
}

TYPED_TEST(DecoderLaws, ASpanInPartsIsAsWellKnownAsAtOnce) {
    for (const auto& parameters : this->variants) {
        TypeParam whole(parameters, this->afferents);
        TypeParam parts(parameters, this->afferents);
        const auto train = regular_train(0, 1ms, 2ms, 100ms);
        const auto middle = train.begin() + 20;
        whole.observe(scene_start, at(100ms), train);
        parts.observe(scene_start, at(100ms), {train.begin(), middle});
        parts.observe(scene_start, at(100ms), {middle, train.end()});
        EXPECT_EQ(parts.estimate(at(102ms)), whole.estimate(at(102ms)));
        EXPECT_EQ(parts.snapshot(), whole.snapshot());
    }
}

TYPED_TEST(DecoderLaws, ALossThatReachesBackMakesTheEndOfTheLastSpanUnknown) {
    for (const auto& parameters : this->variants) {
        TypeParam reaching(parameters, this->afferents);
        TypeParam told(parameters, this->afferents);
        reaching.observe(scene_start, at(500ms), {});
        reaching.lose(at(480ms), at(510ms));
        told.observe(scene_start, at(480ms), {});
        told.lose(at(480ms), at(510ms));
        for (auto* decoder : {&reaching, &told}) decoder->observe(at(510ms), at(520ms), {});
        EXPECT_EQ(reaching.heard_until(), at(520ms));
        // To within the rounding of a subtraction.
        EXPECT_NEAR(reaching.estimate(at(520ms)).sigma_n, told.estimate(at(520ms)).sigma_n, 1e-12);
    }
}

TYPED_TEST(DecoderLaws, TimeBetweenTwoSpansIsLost) {
    for (const auto& parameters : this->variants) {
        TypeParam told(parameters, this->afferents);
        TypeParam seen(parameters, this->afferents);
        const auto train = regular_train(0, 5ms, 10ms, 50ms);
        for (auto* decoder : {&told, &seen}) decoder->observe(scene_start, at(50ms), train);
        told.lose(at(50ms), at(70ms));
        for (auto* decoder : {&told, &seen}) decoder->observe(at(70ms), at(80ms), {});
        EXPECT_EQ(told.heard_until(), at(80ms));
        EXPECT_EQ(told.estimate(at(81ms)), seen.estimate(at(81ms)));
        EXPECT_EQ(told.snapshot(), seen.snapshot());
    }
}

// At the steady rates of a force, the mean over phases is that force, to within the bend of the curves.
TYPED_TEST(DecoderLaws, TheSteadyRatesOfAForceGiveThatForce) {
    constexpr int phases = 50;
    for (const auto& parameters : this->variants) {
        TypeParam decoder(parameters, this->afferents);
        for (const double force_n : {2.0, 5.0, 15.0}) {
            double sum_n = 0;
            for (int phase = 0; phase < phases; ++phase) {
                std::vector<Event> events;
                for (const auto& [address, group, share, patch] : this->afferents.afferents) {
                    if (share == 0) continue;
                    const double rate_hz = this->afferents.groups[group].rate_hz(RateKind::steady, force_n);
                    const Duration interval = rounded(Seconds(1 / rate_hz));
                    // Each neuron runs through all phases, in an order of its own.
                    const Duration first =
                        interval * (phase * (2 * static_cast<int>(address) + 1) % phases) / phases;
                    const auto train = regular_train(address, first, interval, 2s);
                    events.insert(events.end(), train.begin(), train.end());
                }
                std::sort(events.begin(), events.end());
                decoder.restart(scene_start);
                decoder.observe(scene_start, at(2s), events);
                sum_n += decoder.estimate(at(2s)).force_n;
            }
            EXPECT_NEAR(sum_n / phases, force_n, 0.05 * force_n);
        }
    }
}

// Who contradicts whom in a stream that no force explains depends on all that went before; so the decoder
// that asks for it is given one that a force explains.
template <class D>
bool says_left_out(const D& decoder) {
    if constexpr (requires { decoder.left_out(Address{0}); }) return decoder.history() > 1min;
    return false;
}

double repeated_grip_n(double time_s) {
    const double phase = std::fmod(time_s, 3.0);
    return phase < 0.5 ? 0 : phase < 2.5 ? 8 * std::min(1.0, 5 * (phase - 0.5)) : 0;
}

TYPED_TEST(DecoderLaws, ADecoderThatStartsAHistoryAgoAgreesWithOneThatHasAlwaysRun) {
    for (const auto& parameters : this->variants) {
        TypeParam old(parameters, this->afferents);
        TypeParam young(parameters, this->afferents);
        // A step takes 5.5 ms in the mean.
        const int steps = 1000 + static_cast<int>(old.history() / 5ms);
        const bool models_the_force = says_left_out(young);
        const auto stream = models_the_force
                                ? stream_under(this->afferents, old.history() + 5s, repeated_grip_n)
                                : random_stream(11, steps, this->afferents.addresses);
        const TimePoint start = stream[600].begin;
        young.restart(start);
        bool compared = false;
        for (const Step& step : stream) {
            const Estimate estimate = take(old, step);
            if (step.begin < start) continue;
            const Estimate same = take(young, step);
            if (step.now < start + old.history()) continue;
            compared = true;
            // What an infinite kernel forgets is below the rounding of some hundred operations.
            ASSERT_NEAR(same.force_n, estimate.force_n, 1e-12 * this->afferents.largest_grip_n);
            ASSERT_NEAR(same.sigma_n, estimate.sigma_n, 1e-12 * this->afferents.largest_grip_n);
        }
        EXPECT_TRUE(compared);
    }
}

TYPED_TEST(DecoderLaws, NothingIsAllocatedAfterConstruction) {
    const auto stream = random_stream(5, 500, this->afferents.addresses);
    for (const auto& parameters : this->variants) {
        TypeParam decoder(parameters, this->afferents);
        const std::size_t bytes = decoder.bytes();
        for (const Step& step : stream) take(decoder, step);
        const auto snapshot = decoder.snapshot();
        const std::uint64_t before = allocations;
        decoder.restart(scene_start);
        for (const Step& step : stream) take(decoder, step);
        decoder.resume(snapshot);
        decoder.resume_after(scene_start, scene_start, {});
        for (const Step& step : stream) take(decoder, step);
        EXPECT_EQ(allocations, before);
        EXPECT_EQ(decoder.bytes(), bytes);
    }
}

// A copy has no spare room, and shares nothing but the table of intervals that both groups have.
template <class T>
std::size_t uncounted_bytes(const T& of) {
    const std::uint64_t before = allocated_bytes;
    const T copy(of);
    return copy.bytes() - sizeof copy - (allocated_bytes - before);
}

TYPED_TEST(DecoderLaws, BytesAreThoseThatConstructionAllocates) {
    const auto table = IntervalTable::shared(LifParameters().tau_g_ms / LifParameters().tau_m_ms);
    for (const auto& parameters : this->variants) {
        const TypeParam decoder(parameters, this->afferents);
        const std::size_t shared = uncounted_bytes(decoder);
        EXPECT_TRUE(shared == 0 || shared == table->bytes()) << shared;
        EXPECT_LT(decoder.bytes(), 100'000U);
    }
}

TEST(Readouts, BytesAreThoseThatConstructionAllocates) {
    const auto table = IntervalTable::shared(LifParameters().tau_g_ms / LifParameters().tau_m_ms);
    ContactReadout::Parameters contact{.addresses = 5, .patch = {0}, .element_mm2 = 0.25};
    EdgeReadout::Parameters edge{.addresses = 9, .patch = {0}, .settle = 50ms};
    TextureReadout::Parameters texture{.addresses = 9, .patch = {0}, .window = 50ms};
    DecodedAfferents::Group group = group_with(2);
    group.full_scale_n = 60;
    for (Address address = 0; address < 9; ++address) {
        const SkinField field{address % 3 - 1.0, address / 3 - 1.0, 0.25};
        edge.afferents.push_back({address, {field, 1}});
        texture.afferents.push_back({address, field});
        if (address >= 5) continue;
        contact.afferents.push_back({address, group, 0.002, field});
        contact.elements.insert(contact.elements.end(), 2, field);
    }
    contact.addresses = 9;
    for (Address address = 5; address < 9; ++address)
        contact.transients.push_back({address, edge.afferents[address].fitted.field, 0.01, 0.001, 0.03});
    EXPECT_EQ(uncounted_bytes(EdgeReadout(edge)), 0U);
    EXPECT_EQ(uncounted_bytes(TextureReadout(texture)), 0U);
    // The table that all afferents share is counted.
    EXPECT_EQ(uncounted_bytes(ContactReadout(contact)), table->bytes());
    EXPECT_EQ(uncounted_bytes(Readouts({edge, contact, texture})), table->bytes());
}

// With changes that begin, are told and end.
TEST(Readouts, AllocateNothingAfterConstruction) {
    ContactReadout::Parameters parameters{.addresses = 9, .patch = {0}, .element_mm2 = 0.25};
    DecodedAfferents::Group group = group_with(2);
    group.full_scale_n = 60;
    for (Address address = 0; address < 9; ++address) {
        const SkinField field{address % 3 - 1.0, address / 3 - 1.0, 0.25};
        parameters.elements.push_back(field);
        if (address < 5)
            parameters.afferents.push_back({address, group, 0.002, field});
        else
            parameters.transients.push_back({address, field, 1e-3, 1e-4, 0.03});
    }
    const auto stream = random_stream(5, 200, parameters.addresses);
    ContactReadout contact(parameters);
    const auto snapshot = contact.snapshot();
    const std::uint64_t before = allocations;
    for (const Step& step : stream) {
        if (step.lost)
            contact.lose(step.begin, step.end);
        else
            contact.observe(step.begin, step.end, step.events);
        contact.step(step.now);
    }
    contact.resume(snapshot);
    contact.restart(scene_start);
    EXPECT_EQ(allocations, before);
}

TYPED_TEST(DecoderLaws, RefusesAfferentsThatItCannotDecode) {
    for (const auto& parameters : this->variants) {
        EXPECT_THROW(TypeParam(parameters, DecodedAfferents{}), ParameterError);
        DecodedAfferents unsorted = this->afferents;
        std::swap(unsorted.afferents[0], unsorted.afferents[1]);
        EXPECT_THROW(TypeParam(parameters, unsorted), ParameterError);
        DecodedAfferents silent = this->afferents;
        silent.largest_grip_n = 0.2;
        EXPECT_THROW(TypeParam(parameters, silent), ParameterError) << "no neuron fires up to 0.2 N";
    }
}

// One sensor; several that share a force and come to their full scale one after the other.
struct Overload {
    double full_scale_n;
    std::vector<double> shares;
    double force_n;
    double reading_n() const { return full_scale_n * static_cast<double>(shares.size()); }
};
const std::vector<Overload>& overloads() {
    static const std::vector<Overload> all{
        {25, {1}, 28}, {1.2, shares_of_nine(), 40}, {4, {0.5, 0.27, 0.23}, 20}};
    return all;
}

TYPED_TEST(DecoderLaws, WhatIsSaturatedIsAtOrAboveWhatTheSensorsReadAndSaysSo) {
    for (const Overload& overload : overloads()) {
        const DecodedAfferents decoded = sensors(overload.full_scale_n, overload.shares);
        const auto events = pressed(decoded, 3s, [&](double time_s) {
            return std::min(overload.force_n * time_s / 0.3, overload.force_n);
        });
        for (const auto& parameters : this->variants) {
            TypeParam decoder(parameters, decoded);
            // Adapted after 0.6 s.
            const std::vector<Estimate> all = estimates(decoder, events, 3s);
            for (std::size_t i = 120; i < all.size(); ++i) {
                ASSERT_EQ(all[i].doubt, Doubt::saturated) << i;
                ASSERT_TRUE(all[i].is_lower_bound());
                // To within rounding.
                ASSERT_GE(all[i].force_n, (1 - 1e-9) * overload.reading_n()) << i;
            }
        }
    }
}

TYPED_TEST(DecoderLaws, ASaturatedSensorNeverLowersTheUpperBound) {
    for (const Overload& overload : overloads()) {
        const DecodedAfferents decoded = sensors(overload.full_scale_n, overload.shares);
        for (const auto& parameters : this->variants) {
            TypeParam decoder(parameters, decoded);
            double before_n = 0;
            for (const double part : {0.3, 0.6, 0.9, 1.0, 1.2, 1.5, 2.0, 4.0}) {
                const double force_n = part * overload.reading_n();
                const auto events = pressed(decoded, 1500ms, [&](double) { return force_n; });
                decoder.restart(scene_start);
                const std::vector<Estimate> all = estimates(decoder, events, 1500ms);
                // The mean of half a second, in which a count's error averages out to a tenth of itself.
                double upper_n = 0;
                for (std::size_t i = all.size() - 100; i < all.size(); ++i)
                    upper_n += (all[i].force_n + 2 * all[i].sigma_n) / 100;
                EXPECT_GE(upper_n, 0.97 * before_n) << force_n << " N";
                before_n = upper_n;
            }
        }
    }
}

TYPED_TEST(DecoderLaws, AForceBelowFullScaleIsNotSaturated) {
    for (const Overload& overload : overloads()) {
        const DecodedAfferents decoded = sensors(overload.full_scale_n, overload.shares);
        // Half of what the element reads that is loaded most.
        const double force_n = 0.5 * decoded.groups.front().full_scale_n;
        const auto events =
            pressed(decoded, 3s, [&](double time_s) { return std::min(force_n * time_s / 0.3, force_n); });
        for (const auto& parameters : this->variants) {
            TypeParam decoder(parameters, decoded);
            for (const Estimate& estimate : estimates(decoder, events, 3s))
                ASSERT_NE(estimate.doubt, Doubt::saturated);
        }
    }
}

}  // namespace
}  // namespace afferent
