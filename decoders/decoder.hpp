// The concept of a decoder: spans of events in, estimates of the grip force out. Included by programs that
// write a decoder of their own, or generic code for any decoder.
#pragma once

#include <concepts>
#include <cstddef>
#include <span>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// A decoder is a value, constructed from its parameters and a description of the afferents. D(parameters,
// afferents) throws ParameterError if either is invalid. No other member throws, except resume(snapshot) and
// allocations that fail.
//
// Input. Every time before heard_until() has been observed or lost; later times are unknown, unless silence
// is presumed. Spans arrive in order of time.
//
//   observe(begin, end, events)  [begin, end) is known, and these are its events, sorted. Silence is a
//                                measurement: a span without events is as well known as one with many. If
//                                begin > heard_until(), the span between is lost. A span may come in parts:
//                                the same begin and end again, with its later events.
//   lose(begin, end)             Nothing will ever be known of [begin, end). begin <= heard_until(): if less,
//                                because a part was lost, the end of the last span is unknown after all. Its
//                                events that were observed before still count.
//   presume_silence(until)       Events before `until` would have been heard by now. Until a span is observed
//                                or lost, it counts as silent up to there. (Ignoring such spans until their
//                                packets come would ignore only silent ones, and overestimate.)
//   heard_until()                The end of the last span that was observed or lost.
//
// Estimates.
//
//   estimate(now)                The grip force at `now`, which never decreases and is >= heard_until().
//                                Where nothing is known, force and rate are those of the last estimate, sigma
//                                is the largest force that the afferents can tell, and doubt is `unknown`, or
//                                `saturated` where the last estimate's is.
//   history()                    How far back an estimate depends on events. A decoder that restarted that
//                                long ago gives the estimates of one that has always run: exactly if its
//                                kernel ends, otherwise to within rounding.
//
// State. A copy of the decoder would do as a snapshot too, but a Snapshot holds no parameters and no curves.
//
//   restart(start)               As after construction, but nothing before `start` is known.
//   resume_after(start, heard_until, last)
//                                Continues without the history: as restart(start), but the last span that was
//                                observed or lost ended at heard_until <= start, and `last` is the estimate
//                                that stands until something is known.
//   correct(last)                `last` is the estimate that stands until something is known; the history
//                                stays.
//   snapshot()                   The whole state as a value.
//   resume(snapshot)             Continues from there, bit for bit: what follows is what would have followed
//                                for the decoder that gave the snapshot. Throws ParameterError, and changes
//                                nothing, if the snapshot is of other afferents.
//   bytes()                      Memory in use, heap included. A decoder states its bound, and up to which
//                                rate of events it allocates nothing after construction.
template <class D>
concept Decoder = std::constructible_from<D, const typename D::Parameters&, const DecodedAfferents&> &&
    std::copyable<typename D::Snapshot> && std::copyable<typename D::Parameters> &&
    requires(D decoder, const D& constant, TimePoint time, std::span<const Event> events,
             const Estimate& last, const typename D::Snapshot& snapshot) {
    { decoder.observe(time, time, events) } -> std::same_as<void>;
    { decoder.lose(time, time) } -> std::same_as<void>;
    { decoder.presume_silence(time) } -> std::same_as<void>;
    { constant.heard_until() } -> std::same_as<TimePoint>;
    { decoder.estimate(time) } -> std::same_as<Estimate>;
    { constant.history() } -> std::same_as<Duration>;
    { decoder.restart(time) } -> std::same_as<void>;
    { decoder.resume_after(time, time, last) } -> std::same_as<void>;
    { decoder.correct(last) } -> std::same_as<void>;
    { constant.snapshot() } -> std::same_as<typename D::Snapshot>;
    { decoder.resume(snapshot) } -> std::same_as<void>;
    { constant.bytes() } -> std::same_as<std::size_t>;
};

}  // namespace afferent
