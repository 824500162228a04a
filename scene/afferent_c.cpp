#include "afferent/scene/afferent.h"

#include <algorithm>
#include <exception>
#include <span>
#include <string>
#include <vector>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/controller.hpp"
#include "afferent/scene/coprocessor.hpp"
#include "afferent/scene/scene.hpp"

using namespace afferent;

struct afferent_coprocessor {
    explicit afferent_coprocessor(const Plan& plan)
        : addresses(plan.addresses), elements(plan.elements), coprocessor(plan) {}

    std::uint32_t addresses;
    std::uint32_t elements;
    Coprocessor coprocessor;
    std::vector<Event> kept;  // those that the caller had no room for yet
    std::size_t taken = 0;    // of them
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
    return guarded<int>(coprocessor->error, AFFERENT_FAILED, [&] {
        const std::uint64_t refused = coprocessor->coprocessor.refused_samples();
        coprocessor->coprocessor.push({time_point(time_ns), first, {forces_n, count}});
        if (coprocessor->coprocessor.refused_samples() == refused) return AFFERENT_OK;
        coprocessor->error = "a sample is not finite, or is of an element that the scene does not have";
        return AFFERENT_FAILED;
    });
}

long afferent_advance(afferent_t* coprocessor, int64_t until_ns, afferent_event* events, size_t capacity) {
    if (!coprocessor || (!events && capacity > 0)) return AFFERENT_FAILED;
    return guarded<long>(coprocessor->error, AFFERENT_FAILED, [&] {
        std::vector<Event>& kept = coprocessor->kept;
        kept.erase(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(coprocessor->taken));
        coprocessor->taken = 0;
        if (time_point(until_ns) > coprocessor->coprocessor.now()) {
            const auto computed = coprocessor->coprocessor.advance(time_point(until_ns));
            kept.insert(kept.end(), computed.begin(), computed.end());
        }
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
        *step = {now_ns,    done.estimate.force_n, done.estimate.sigma_n, done.estimate.rate_hz,
                 done.gain, done.command};
        return AFFERENT_OK;
    });
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
