// The controller that a hand embeds.
#include "afferent/engine/controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

constexpr Duration span = 5ms;
constexpr Emg effort_of_a_half{User::rest_counts + User::full_scale_counts / 2, User::rest_counts};

Scene pressed(scene::Transport transport = scene::Tcp()) {
    Scene scene;
    scene.source = scene::Profile{{{.time_s = 0, .force_n = 4}}};
    scene.link.transport = transport;
    return scene;
}

// The spans of a coprocessor that is pressed with a force that rises slowly, and at last holds, and the
// frames that they cross a link in.
struct EventStream {
    explicit EventStream(const Scene& scene, int spans = 100, int rising = std::numeric_limits<int>::max())
        : plan(make_plan(scene, Commands::wanted)), coprocessor(plan) {
        Packetizer packetizer(packet_layout(plan));
        FrameWriter writer;
        for (int k = 0; k < spans; ++k) {
            const TimePoint begin = scene_start + k * span;
            coprocessor.push(
                {begin, 0, std::vector<double>(plan.elements, 0.2 + 0.01 * std::min(k, rising))});
            const auto fired = coprocessor.advance(begin + span - Duration(1));
            events.emplace_back(fired.begin(), fired.end());
            packetizer.push(fired);
            frames.emplace_back();
            packetizer.close(begin + span, [&](const auto& packet) {
                const auto bytes = writer.datagram(packet);
                frames.back().emplace_back(bytes.begin(), bytes.end());
            });
        }
    }

    Plan plan;
    Coprocessor coprocessor;
    std::vector<std::vector<Event>> events;
    std::vector<std::vector<std::vector<std::byte>>> frames;
};

void expect_equal(const ControllerStep& a, const ControllerStep& b) {
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.estimate.force_n, b.estimate.force_n);
    EXPECT_EQ(a.estimate.sigma_n, b.estimate.sigma_n);
    EXPECT_EQ(a.gain, b.gain);
    EXPECT_EQ(a.command, b.command);
}

// Five steps of the controller after each span.
template <class Take>
ControllerStep drive(Controller& controller, int begin, int end, const Take& take) {
    for (int k = begin; k < end; ++k) {
        take(k);
        for (int step = 1; step <= 5; ++step)
            controller.step(scene_start + (k + 1) * span + step * 1ms, effort_of_a_half);
    }
    return controller.last_step();
}

TEST(Controller, EstimatesTheForceThatTheCoprocessorFeels) {
    const EventStream stream(pressed());
    Controller controller(stream.plan);
    const ControllerStep last = drive(controller, 0, 100, [&](int k) {
        for (const auto& frame : stream.frames[static_cast<std::size_t>(k)])
            ASSERT_TRUE(controller.receive(frame));
    });
    // Each of nine elements feels 1.19 N at the end, on a slow ramp: what the adaptation leaves is within a
    // third.
    EXPECT_NEAR(last.estimate.force_n, 9 * 1.19, 9 * 1.19 / 3);
    EXPECT_EQ(last.gain, 0) << "beyond the limit of 10 N";
}

// Ticks of 1 us are as fine as the stamps of these events need to be for the same estimate: a count in a
// window.
TEST(Controller, TakesPacketsAndSpansAlike) {
    Scene scene = pressed();
    scene.link.tick_us = 1;
    const EventStream stream(scene);
    Controller packets(stream.plan);
    Controller spans(stream.plan);
    const ControllerStep a = drive(packets, 0, 60, [&](int k) {
        for (const auto& frame : stream.frames[static_cast<std::size_t>(k)])
            ASSERT_TRUE(packets.receive(frame));
    });
    const ControllerStep b = drive(spans, 0, 60, [&](int k) {
        spans.observe(scene_start + k * span, scene_start + (k + 1) * span,
                      stream.events[static_cast<std::size_t>(k)]);
    });
    EXPECT_GT(a.estimate.force_n, 1);
    expect_equal(a, b);
}

TEST(Controller, ContinuesFromASnapshotBitForBit) {
    for (const bool exponential : {false, true}) {
        Scene scene = pressed();
        if (exponential) scene.decoder.kind = scene::Exponential();
        // At 300 ms, in the middle of the brake.
        if (exponential) scene.gain.brake = {.command = 0.05, .contact_n = 1};
        const EventStream stream(scene);
        Controller whole(stream.plan);
        Controller resumed(stream.plan);
        const auto into = [&](Controller& controller) {
            return [&](int k) {
                for (const auto& frame : stream.frames[static_cast<std::size_t>(k)])
                    ASSERT_TRUE(controller.receive(frame));
            };
        };
        drive(whole, 0, 50, into(whole));
        resumed.resume(whole.snapshot());
        for (int k = 50; k < 100; ++k)
            expect_equal(drive(whole, k, k + 1, into(whole)), drive(resumed, k, k + 1, into(resumed)));
    }
}

TEST(Controller, ContinuesItsReadoutsFromASnapshot) {
    Scene scene = Scene::from_text(
        "patch { name: 'skin' kind: SA1 outline { rectangle { width_mm: 4 height_mm: 4 } } sensor { "
        "full_scale_n: 1000 } } "
        "source { pushed {} } link { tcp {} } decoder { filter {} contact {} }");
    const EventStream stream(scene);
    Controller whole(stream.plan);
    Controller resumed(stream.plan);
    const auto told_by = [&](Controller& controller, int begin, int end) {
        std::vector<PatchReadout> all;
        for (int k = begin; k < end; ++k) {
            controller.observe(scene_start + k * span, scene_start + (k + 1) * span,
                               stream.events[static_cast<std::size_t>(k)]);
            for (int step = 1; step <= 5; ++step) {
                controller.step(scene_start + (k + 1) * span + step * 1ms, effort_of_a_half);
                const auto& told = controller.last_step().readouts;
                all.insert(all.end(), told.begin(), told.end());
            }
        }
        return all;
    };
    told_by(whole, 0, 50);
    resumed.resume(whole.snapshot());
    const auto expected = told_by(whole, 50, 100);
    ASSERT_GT(expected.size(), 10U);
    EXPECT_GT(std::get<PatchContact>(expected.back()).estimate.force_n, 0);
    EXPECT_EQ(told_by(resumed, 50, 100), expected);
}

TEST(Controller, KnowsALostPacketAsUnknown) {
    const EventStream stream(pressed());
    Controller controller(stream.plan);
    const auto take = [&](int k) {
        if (k >= 50 && k < 56) return;
        for (const auto& frame : stream.frames[static_cast<std::size_t>(k)])
            ASSERT_TRUE(controller.receive(frame));
    };
    const ControllerStep lossy = drive(controller, 0, 60, take);
    Controller complete(stream.plan);
    const ControllerStep whole = drive(complete, 0, 60, [&](int k) {
        for (const auto& frame : stream.frames[static_cast<std::size_t>(k)])
            ASSERT_TRUE(complete.receive(frame));
    });
    EXPECT_GT(lossy.estimate.sigma_n, whole.estimate.sigma_n);
    Controller deceived(stream.plan);
    const ControllerStep silent = drive(deceived, 0, 60, [&](int k) {
        const std::vector<Event> nothing;
        deceived.observe(scene_start + k * span, scene_start + (k + 1) * span,
                         k >= 50 && k < 56 ? nothing : stream.events[static_cast<std::size_t>(k)]);
    });
    // Each of nine elements feels 0.79 N in the end; what the adaptation leaves is within a third.
    EXPECT_NEAR(lossy.estimate.force_n, 9 * 0.79, 9 * 0.79 / 3) << "what is lost is not taken for silence";
    EXPECT_LT(silent.estimate.force_n, 9 * 0.79 / 2) << "as it is here";
}

using DecoderKind = decltype(scene::Decoder::kind);

// Rises for half a second and holds for a second: what is foreseen then comes, and is not sent.
struct ForeseenStream : EventStream {
    explicit ForeseenStream(DecoderKind decoder) : EventStream(scene_of(std::move(decoder)), spans, 100) {
        PacketReceiver receiver(packet_layout(plan));
        FrameCounts counts;
        proto::Envelope message;
        for (int k = 0; k < spans; ++k)
            for (const auto& frame : frames[static_cast<std::size_t>(k)]) {
                EXPECT_TRUE(read_datagram(frame, message, counts));
                receptions[k].keep(receiver.receive(message).value());
                told.insert(told.end(), receptions[k].events.begin(), receptions[k].events.end());
            }
    }
    static Scene scene_of(DecoderKind decoder) {
        Scene scene = pressed();
        scene.link.encoding = scene::Encoding::predicted;
        scene.link.timing_tolerance_us = 1000;
        scene.decoder.kind = std::move(decoder);
        return scene;
    }
    void tell(int k, Controller& controller) const {
        const auto found = receptions.find(k);
        if (found != receptions.end()) controller.receive(found->second);
    }
    // What the packets say of the span, whenever they do.
    std::vector<Event> told_of(int k) const {
        std::vector<Event> found;
        for (const Event& event : told)
            if (event.time >= scene_start + k * span && event.time < scene_start + (k + 1) * span)
                found.push_back(event);
        return found;
    }

    static constexpr int spans = 300;
    std::map<int, KeptReception> receptions;  // by the span with which the packet closes
    std::vector<Event> told;
};

TEST(Controller, PresumesWhatIsForeseenAsIfItWereTold) {
    const ForeseenStream stream{scene::SlidingWindow()};
    EXPECT_LT(stream.receptions.size(), 200U) << "a third of the spans has no packet";
    Controller presuming(stream.plan);
    Controller told_all(stream.plan);
    int presumed = 0;
    for (int k = 0; k <= stream.receptions.rbegin()->first; ++k) {
        const ControllerStep a = drive(presuming, k, k + 1, [&](int at) { stream.tell(at, presuming); });
        const ControllerStep b = drive(told_all, k, k + 1, [&](int at) {
            told_all.observe(scene_start + at * span, scene_start + (at + 1) * span, stream.told_of(at));
        });
        if (k < stream.receptions.begin()->first) continue;
        // The last of the five steps is 10 ms after the begin of the span, later than its delivery.
        ASSERT_EQ(a.known_until, b.known_until) << k;
        expect_equal(a, b);
        presumed += a.known_until > presuming.heard_until();
    }
    EXPECT_GT(presumed, 100);
}

// A controller that made no step meanwhile has presumed nothing.
TEST(Controller, TakesBackWhatItPresumed) {
    const ForeseenStream streams[] = {ForeseenStream(scene::SlidingWindow()),
                                      ForeseenStream(scene::Filter())};
    for (const ForeseenStream& stream : streams) {
        Controller presuming(stream.plan);
        Controller waiting(stream.plan);
        const auto last = std::prev(stream.receptions.end());
        for (Controller* each : {&presuming, &waiting})
            drive(*each, 0, last->first + 1, [&](int k) { stream.tell(k, *each); });
        const TimePoint begin = last->second.known.end;
        ASSERT_GT(std::ranges::count_if(last->second.presumed,
                                        [&](const Event& event) { return event.time < begin + 3 * span; }),
                  1);
        const ControllerStep presumed = drive(presuming, last->first + 1, last->first + 5, [](int) {});
        EXPECT_EQ(presumed.known_until, begin + 4 * span);
        EXPECT_EQ(presuming.heard_until(), begin);
        // They were silent after all.
        for (Controller* each : {&presuming, &waiting}) each->observe(begin, begin + 3 * span, {});
        const TimePoint now = presumed.time + 1ms;
        const ControllerStep a = presuming.step(now, effort_of_a_half);
        const ControllerStep b = waiting.step(now, effort_of_a_half);
        EXPECT_EQ(a.estimate.force_n, b.estimate.force_n);
        EXPECT_EQ(a.estimate.sigma_n, b.estimate.sigma_n);
        EXPECT_LT(a.estimate.force_n, presumed.estimate.force_n);
    }
}

TEST(Controller, ContinuesWhatItPresumesFromASnapshotBitForBit) {
    const ForeseenStream stream{scene::Filter()};
    Controller whole(stream.plan);
    Controller resumed(stream.plan);
    const auto last = std::prev(stream.receptions.end());
    drive(whole, 0, last->first + 2, [&](int k) { stream.tell(k, whole); });
    ASSERT_GT(whole.last_step().known_until, whole.heard_until());
    resumed.resume(whole.snapshot());
    for (int k = last->first + 2; k < last->first + 10; ++k)
        expect_equal(drive(whole, k, k + 1, [](int) {}), drive(resumed, k, k + 1, [](int) {}));
}

// Whether a span counts as silent once its packet would have been delivered. Three spans before it are heard
// in time, as of a packet that says that they were.
bool presumes(Controller& controller, TimePoint begin) {
    controller.observe(begin, begin + 3 * span, {});
    controller.step(begin + 3 * span, effort_of_a_half);
    return controller.step(begin + 4 * span + 3ms, effort_of_a_half).known_until == begin + 4 * span;
}

TEST(Controller, PresumesNothingForAWhileAfterAPacketThatWasLateOrLost) {
    for (const bool late : {false, true}) {
        Controller controller(pressed());
        EXPECT_TRUE(presumes(controller, scene_start));
        const TimePoint due = scene_start + 3 * span;
        if (late)
            controller.observe(due, due + span, {});
        else
            controller.lose(due, due + span);
        const TimePoint trusted = controller.last_step().time + 10s;
        EXPECT_EQ(controller.presumes_from(), trusted);
        // So that the last step below is at that time.
        controller.observe(due + span, due + 2 * span, {});
        TimePoint now = due + 2 * span;
        for (; now + 4 * span + 3ms < trusted; now += 3 * span)
            ASSERT_FALSE(presumes(controller, now)) << (now - scene_start) / 1ms;
        EXPECT_EQ(controller.presumes_from(), trusted);
        EXPECT_TRUE(presumes(controller, now));
        EXPECT_EQ(controller.last_step().time, trusted);
        controller.lose(now + 3 * span, now + 4 * span);
        EXPECT_GT(controller.presumes_from(), trusted);
        controller.restart(now + 4 * span);
        EXPECT_EQ(controller.presumes_from(), scene_start) << "another session is another link";
    }
}

// A hand that joins has a gap before its first packet. Its link was neither late nor lossy for that.
TEST(Controller, PresumesAfterAGapOfWhichNothingWasDue) {
    Controller controller(pressed());
    controller.restart(at(100ms));
    controller.lose(at(100ms), at(105ms));
    EXPECT_TRUE(presumes(controller, at(105ms)));
    // By its last step a packet that ends at 125 ms would have been there.
    controller.lose(at(125ms), at(130ms));
    EXPECT_EQ(controller.presumes_from(), scene_start);
}

// As it was at that time before: a packet of a span that was due then is late.
TEST(Controller, ResumesItsTrustInTheLink) {
    Controller controller(pressed());
    controller.resume_after(at(1003ms), at(980ms), {}, at(500ms));
    EXPECT_EQ(controller.presumes_from(), at(500ms));
    controller.observe(at(980ms), at(1s), {});
    EXPECT_EQ(controller.presumes_from(), at(1003ms) + 10s);
    controller.resume_after(at(1003ms), at(980ms), {}, at(500ms));
    controller.observe(at(980ms), at(1005ms), {});
    EXPECT_EQ(controller.presumes_from(), at(500ms));
}

TEST(Controller, KeepsWhatItPresumedLastWhereNothingIsKnown) {
    const ForeseenStream stream{scene::Filter()};
    Controller controller(stream.plan);
    const auto last = std::prev(stream.receptions.end());
    drive(controller, 0, last->first + 1, [&](int k) { stream.tell(k, controller); });
    const double told_n = controller.last_step().estimate.force_n;
    const double presumed_n =
        drive(controller, last->first + 1, last->first + 5, [](int) {}).estimate.force_n;
    ASSERT_NE(presumed_n, told_n);
    const TimePoint end = last->second.known.end + 60s;
    controller.lose(last->second.known.end, end);
    const ControllerStep step = controller.step(end, effort_of_a_half);
    EXPECT_EQ(step.estimate.doubt, Doubt::unknown);
    EXPECT_EQ(step.estimate.force_n, presumed_n);
}

TEST(Controller, RefusesWhatIsNoPacketOfItsScene) {
    const EventStream stream(pressed());
    Controller controller(stream.plan);
    const auto& frame = (stream.frames.at(0).empty() ? stream.frames.at(4) : stream.frames.at(0)).at(0);
    for (std::size_t length = 0; length < frame.size(); ++length)
        EXPECT_FALSE(controller.receive(std::span(frame).first(length))) << length;
    EXPECT_TRUE(controller.receive(frame));
    EXPECT_FALSE(controller.receive(frame)) << "twice";
    Controller without(pressed(scene::InProcess()));
    EXPECT_FALSE(without.receive(frame));
}

TEST(Controller, DoesNotCloseUnlessItOperates) {
    Controller controller(pressed());
    const auto silent = [&](int k) {
        controller.observe(scene_start + k * span, scene_start + (k + 1) * span, {});
    };
    EXPECT_GT(drive(controller, 0, 60, silent).command, 0.2) << "no force: the user closes";
    controller.set_state(GripState::frozen);
    EXPECT_LE(drive(controller, 60, 70, [](int) {}).command, 0);
    controller.set_state(GripState::safe);
    EXPECT_LE(drive(controller, 70, 80, [](int) {}).command, 0);
    controller.restart(scene_start + 80 * span);
    EXPECT_EQ(controller.state(), GripState::operating);
}

TEST(Controller, BrakesOnceWhereTheHandTouchesWhileItCloses) {
    Scene scene = pressed();
    scene.gain.brake = {.contact_n = 1};
    const EventStream stream(scene);
    Controller controller(stream.plan);
    // Spans of silence, those of the stream, and silence again. Counts the steps that drive the motor
    // backwards.
    constexpr int touched = 100, released = 200;
    const auto braked = [&](int begin, int end) {
        int steps = 0;
        for (int k = begin; k < end; ++k) {
            std::vector<Event> events;
            if (k >= touched && k < released) events = stream.events[static_cast<std::size_t>(k - touched)];
            for (Event& event : events) event.time += touched * span;
            controller.observe(scene_start + k * span, scene_start + (k + 1) * span, events);
            for (int step = 1; step <= 5; ++step)
                steps +=
                    controller.step(scene_start + (k + 1) * span + step * 1ms, effort_of_a_half).command < 0;
        }
        return steps;
    };
    EXPECT_EQ(braked(0, touched), 0);
    // The effort of a half has brought the modelled motor to half of its speed: from there to a twentieth of
    // it under a command of −1, at a time constant of 60 ms.
    EXPECT_EQ(braked(touched, released), std::ceil(60 * std::log((1 + 0.5) / (1 + 0.5 / 20))));
    EXPECT_EQ(braked(released, 400), 0);
    EXPECT_GT(controller.last_step().command, 0.4);
}

TEST(Controller, DoesNotCloseWhileNothingIsKnown) {
    Controller controller(pressed());
    const ControllerStep step = drive(controller, 0, 60, [](int) {});
    EXPECT_EQ(step.estimate.doubt, Doubt::unknown);
    EXPECT_LE(step.command, 0);
    Scene as_the_paper = pressed();
    as_the_paper.gain.doubtful = EmgGain::Doubtful::as_estimated;
    Controller paper(as_the_paper);
    EXPECT_GT(drive(paper, 0, 60, [](int) {}).command, 0.2);
}

TEST(Controller, LeavesAnElectrodeThatReadsNothingAtWhatItReadBefore) {
    Controller controller(pressed());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const ControllerStep before = drive(controller, 0, 60, [](int) {});
    EXPECT_NEAR(before.effort.closing, 0.5, 0.01) << "300 ms of it";
    const ControllerStep after = controller.step(before.time + 1ms, {nan, nan});
    EXPECT_EQ(after.effort.closing, before.effort.closing);
    EXPECT_TRUE(std::isfinite(after.command));
}

}  // namespace
}  // namespace afferent
