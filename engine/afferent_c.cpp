#include "afferent/engine/afferent.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/scene/scene.hpp"

using namespace afferent;

struct afferent_coprocessor {
    explicit afferent_coprocessor(const Plan& plan)
        : addresses(plan.addresses),
          elements(plan.elements),
          coprocessor(plan),
          most_waiting(std::max(std::size_t{1} << 20, 8 * std::size_t{plan.elements})) {
        for (const PatchPlan& patch : plan.patches)
            if (patch.owns_elements)
                ranges.push_back({patch.first_element, patch.elements(), patch.sensor.full_scale_n,
                                  patch.sensor.out_of_range == scene::OutOfRange::refuse});
    }

    // The range of what a patch's sensors can have read.
    struct Range {
        Address first;
        std::uint32_t elements;
        double full_scale_n;
        bool refuses;
    };

    // Takes the forces as from a table; those that would be refused become NaN, which the coprocessor counts.
    void take_in_range(std::uint32_t first, std::span<const double> forces_n) {
        scan.assign(forces_n.begin(), forces_n.end());
        for (const Range& range : ranges) {
            const std::size_t begin = std::max<std::size_t>(first, range.first);
            const std::size_t end =
                std::min<std::size_t>(first + scan.size(), std::size_t{range.first} + range.elements);
            for (std::size_t element = begin; element < end; ++element) {
                double& force_n = scan[element - first];
                if (!std::isfinite(force_n) || (force_n >= 0 && force_n <= range.full_scale_n)) continue;
                if (range.refuses) {
                    force_n = std::numeric_limits<double>::quiet_NaN();
                    continue;
                }
                force_n = std::clamp(force_n, 0.0, range.full_scale_n);
                ++clipped;
            }
        }
    }

    // The events after those that have been taken, up to that time; at least `enough` of them, unless there
    // are no more. Advances by short spans, and by longer ones while nobody fires.
    void compute(TimePoint until, std::size_t enough) {
        kept.erase(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(taken));
        taken = 0;
        asked_until = std::max(asked_until, until);
        Duration span = shortest_span;
        while (kept.size() <= enough && coprocessor.now() < until) {
            const Duration left = until - coprocessor.now();
            const auto computed = coprocessor.advance(coprocessor.now() + std::min(span, left));
            kept.insert(kept.end(), computed.begin(), computed.end());
            if (!computed.empty())
                span = shortest_span;
            else if (span < left)
                span += std::min(span, left - span);
        }
    }

    static constexpr Duration shortest_span = 10ms;

    std::uint32_t addresses;
    std::uint32_t elements;
    Coprocessor coprocessor;
    std::size_t most_waiting;  // samples
    std::vector<Range> ranges;
    std::vector<double> scan;
    std::uint64_t clipped = 0;
    TimePoint asked_until = scene_start;  // the coprocessor may not have come so far yet
    std::vector<Event> kept;              // those that the caller had no room for yet
    std::size_t taken = 0;                // of them
    std::string error;
};

struct afferent_controller {
    explicit afferent_controller(const Plan& plan) : addresses(plan.addresses), controller(plan) {}

    Address addresses;
    Controller controller;
    std::vector<Event> events;
    std::string error;
};

struct afferent_snapshot {
    Controller::Snapshot controller;
};

namespace {

thread_local std::string open_error;
thread_local std::string controller_open_error;

// Runs the body. No exception leaves: its text is kept, and `failed` returned.
template <class Result, class Body>
Result guarded(std::string& error, Result failed, Body&& body) noexcept {
    error.clear();
    try {
        return body();
    } catch (const std::exception& exception) {
        try {
            error = exception.what();
        } catch (...) {  // no memory even for the reason
        }
    }
    return failed;
}

TimePoint time_point(std::int64_t ns) { return scene_start + Duration(ns); }

void require_span(const Controller& controller, TimePoint begin, TimePoint end) {
    if (end < begin)
        throw ParameterError("end_ns", "not before begin_ns", std::to_string((end - scene_start).count()));
    if (begin < controller.heard_until())
        throw ParameterError("begin_ns", "not before the end of the last span",
                             std::to_string((begin - scene_start).count()));
}

}  // namespace

extern "C" {

const char* afferent_version(void) { return AFFERENT_VERSION; }

afferent_t* afferent_open_file(const char* path) {
    return guarded<afferent_t*>(open_error, nullptr, [&] {
        if (!path) throw SceneError({"no path"});
        return new afferent_coprocessor(make_plan(Scene::from_file(path)));
    });
}

afferent_t* afferent_open_text(const char* text) {
    return guarded<afferent_t*>(open_error, nullptr, [&] {
        if (!text) throw SceneError({"no text"});
        return new afferent_coprocessor(make_plan(Scene::from_text(text)));
    });
}

void afferent_close(afferent_t* coprocessor) { delete coprocessor; }

const char* afferent_error(const afferent_t* coprocessor) {
    return coprocessor ? coprocessor->error.c_str() : open_error.c_str();
}

uint32_t afferent_addresses(const afferent_t* coprocessor) {
    return coprocessor ? coprocessor->addresses : 0;
}

uint32_t afferent_elements(const afferent_t* coprocessor) { return coprocessor ? coprocessor->elements : 0; }

int afferent_push(afferent_t* coprocessor, int64_t time_ns, uint32_t first, const double* forces_n,
                  size_t count) {
    if (!coprocessor || (!forces_n && count > 0)) return AFFERENT_FAILED;
    return guarded<int>(coprocessor->error, AFFERENT_FAILED, [&]() -> int {
        if (count > coprocessor->most_waiting - coprocessor->coprocessor.waiting_samples()) {
            coprocessor->error = "more than " + std::to_string(coprocessor->most_waiting) +
                                 " samples would wait: advance, and push them again";
            return AFFERENT_FULL;
        }
        const std::uint64_t refused = coprocessor->coprocessor.refused_samples();
        coprocessor->take_in_range(first, {forces_n, count});
        coprocessor->coprocessor.push(
            {std::max(time_point(time_ns), coprocessor->asked_until), first, coprocessor->scan});
        if (coprocessor->coprocessor.refused_samples() == refused) return AFFERENT_OK;
        coprocessor->error =
            "a sample is not finite, is out of the range of a sensor with out_of_range: REFUSE, or is of an "
            "element "
            "that the scene does not have";
        return AFFERENT_FAILED;
    });
}

uint64_t afferent_clipped(const afferent_t* coprocessor) { return coprocessor ? coprocessor->clipped : 0; }

long afferent_advance(afferent_t* coprocessor, int64_t until_ns, afferent_event* events, size_t capacity) {
    if (!coprocessor || (!events && capacity > 0)) return AFFERENT_FAILED;
    return guarded<long>(coprocessor->error, AFFERENT_FAILED, [&] {
        std::vector<Event>& kept = coprocessor->kept;
        coprocessor->compute(time_point(until_ns), capacity);
        coprocessor->taken = std::min(kept.size(), capacity);
        for (std::size_t i = 0; i < coprocessor->taken; ++i)
            events[i] = {(kept[i].time - scene_start).count(), kept[i].address};
        return static_cast<long>(coprocessor->taken);
    });
}

int afferent_reset(afferent_t* coprocessor) {
    if (!coprocessor) return AFFERENT_FAILED;
    return guarded<int>(coprocessor->error, AFFERENT_FAILED, [&] {
        coprocessor->coprocessor.reset();
        coprocessor->kept.clear();
        coprocessor->taken = 0;
        coprocessor->asked_until = scene_start;
        coprocessor->clipped = 0;
        return AFFERENT_OK;
    });
}

afferent_controller_t* afferent_controller_open_file(const char* path) {
    return guarded<afferent_controller_t*>(controller_open_error, nullptr, [&] {
        if (!path) throw SceneError({"no path"});
        return new afferent_controller(make_plan(Scene::from_file(path), Commands::wanted));
    });
}

afferent_controller_t* afferent_controller_open_text(const char* text) {
    return guarded<afferent_controller_t*>(controller_open_error, nullptr, [&] {
        if (!text) throw SceneError({"no text"});
        return new afferent_controller(make_plan(Scene::from_text(text), Commands::wanted));
    });
}

void afferent_controller_close(afferent_controller_t* controller) { delete controller; }

const char* afferent_controller_error(const afferent_controller_t* controller) {
    return controller ? controller->error.c_str() : controller_open_error.c_str();
}

int afferent_controller_receive(afferent_controller_t* controller, const void* frame, size_t bytes) {
    if (!controller || (!frame && bytes > 0)) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        const auto received = controller->controller.receive({static_cast<const std::byte*>(frame), bytes});
        if (received) return AFFERENT_OK;
        controller->error = received.error().text;
        return AFFERENT_FAILED;
    });
}

int afferent_controller_observe(afferent_controller_t* controller, int64_t begin_ns, int64_t end_ns,
                                const afferent_event* events, size_t count) {
    if (!controller || (!events && count > 0)) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        const TimePoint begin = time_point(begin_ns);
        const TimePoint end = time_point(end_ns);
        require_span(controller->controller, begin, end);
        std::vector<Event>& span = controller->events;
        span.clear();
        for (const afferent_event& event : std::span(events, count)) {
            span.push_back({time_point(event.time_ns), event.address});
            if (event.address >= controller->addresses)
                throw ParameterError("address", "below " + std::to_string(controller->addresses),
                                     event.address);
            if (span.back().time < begin || span.back().time >= end ||
                (span.size() > 1 && span.back() < *(span.end() - 2)))
                throw ParameterError("time_ns", "within the span, and sorted", std::to_string(event.time_ns));
        }
        controller->controller.observe(begin, end, span);
        return AFFERENT_OK;
    });
}

int afferent_controller_lose(afferent_controller_t* controller, int64_t begin_ns, int64_t end_ns) {
    if (!controller) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        require_span(controller->controller, time_point(begin_ns), time_point(end_ns));
        controller->controller.lose(time_point(begin_ns), time_point(end_ns));
        return AFFERENT_OK;
    });
}

int afferent_controller_step(afferent_controller_t* controller, int64_t now_ns, double closing_counts,
                             double opening_counts, afferent_step* step) {
    if (!controller || !step) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        const TimePoint now = time_point(now_ns);
        if (now < controller->controller.last_step().time)
            throw ParameterError("now_ns", "not before the step before", std::to_string(now_ns));
        const ControllerStep& done = controller->controller.step(now, {closing_counts, opening_counts});
        *step = {now_ns,
                 done.estimate.force_n,
                 done.estimate.sigma_n,
                 done.estimate.rate_hz,
                 done.gain,
                 done.command,
                 static_cast<int>(done.estimate.doubt)};
        return AFFERENT_OK;
    });
}

static_assert(static_cast<int>(Doubt::slow) == AFFERENT_DOUBT_SLOW);
static_assert(static_cast<int>(Doubt::unheard) == AFFERENT_DOUBT_UNHEARD);
static_assert(static_cast<int>(Doubt::contradicted) == AFFERENT_DOUBT_CONTRADICTED);
static_assert(static_cast<int>(Doubt::unknown) == AFFERENT_DOUBT_UNKNOWN);
static_assert(static_cast<int>(last_doubt) == AFFERENT_DOUBT_SATURATED);

static const Estimate& estimate_of_part(const Controller& controller, size_t part) {
    const auto& parts = controller.last_step().parts;
    if (part >= parts.size())
        throw ParameterError("part", "below " + std::to_string(parts.size()), std::to_string(part));
    return parts[part].estimate;
}

size_t afferent_controller_parts(const afferent_controller_t* controller) {
    return controller ? controller->controller.last_step().parts.size() : 0;
}

int afferent_controller_part(afferent_controller_t* controller, size_t part, double* force_n,
                             double* sigma_n) {
    if (!controller || !force_n || !sigma_n) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        const Estimate& estimate = estimate_of_part(controller->controller, part);
        *force_n = estimate.force_n;
        *sigma_n = estimate.sigma_n;
        return AFFERENT_OK;
    });
}

int afferent_controller_part_doubt(afferent_controller_t* controller, size_t part, int* doubt) {
    if (!controller || !doubt) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        *doubt = static_cast<int>(estimate_of_part(controller->controller, part).doubt);
        return AFFERENT_OK;
    });
}

const char* afferent_doubt_name(int doubt) {
    return doubt > 0 && doubt <= AFFERENT_DOUBT_SATURATED ? name(static_cast<Doubt>(doubt))
                                                          : name(Doubt::none);
}

int afferent_controller_set_state(afferent_controller_t* controller, int state) {
    if (!controller) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        if (state < AFFERENT_OPERATING || state > AFFERENT_SAFE)
            throw ParameterError("state", "AFFERENT_OPERATING, AFFERENT_FROZEN or AFFERENT_SAFE", state);
        controller->controller.set_state(static_cast<GripState>(state));
        return AFFERENT_OK;
    });
}

int afferent_controller_restart(afferent_controller_t* controller, int64_t now_ns) {
    if (!controller) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        controller->controller.restart(time_point(now_ns));
        return AFFERENT_OK;
    });
}

afferent_snapshot_t* afferent_controller_snapshot(afferent_controller_t* controller) {
    if (!controller) return nullptr;
    return guarded<afferent_snapshot_t*>(
        controller->error, nullptr, [&] { return new afferent_snapshot{controller->controller.snapshot()}; });
}

int afferent_controller_resume(afferent_controller_t* controller, const afferent_snapshot_t* snapshot) {
    if (!controller || !snapshot) return AFFERENT_FAILED;
    return guarded<int>(controller->error, AFFERENT_FAILED, [&] {
        controller->controller.resume(snapshot->controller);
        return AFFERENT_OK;
    });
}

void afferent_snapshot_free(afferent_snapshot_t* snapshot) { delete snapshot; }

}  // extern "C"
