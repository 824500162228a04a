#include "afferent/scene/afferent.h"

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

#include "afferent/scene/coprocessor.hpp"
#include "afferent/scene/scene.hpp"

using namespace afferent;

struct afferent_coprocessor {
    explicit afferent_coprocessor(Scene&& read) : scene(std::move(read)), coprocessor(scene) {}

    Scene scene;
    Coprocessor coprocessor;
    std::vector<Event> kept;  // those that the caller had no room for yet
    std::size_t taken = 0;    // of them
    std::string error;
};

namespace {

thread_local std::string open_error;

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

}  // namespace

extern "C" {

const char* afferent_version(void) { return AFFERENT_VERSION; }

afferent_t* afferent_open_file(const char* path) {
    return guarded<afferent_t*>(open_error, nullptr, [&] {
        if (!path) throw SceneError({"no path"});
        return new afferent_coprocessor(Scene::from_file(path));
    });
}

afferent_t* afferent_open_text(const char* text) {
    return guarded<afferent_t*>(open_error, nullptr, [&] {
        if (!text) throw SceneError({"no text"});
        return new afferent_coprocessor(Scene::from_text(text));
    });
}

void afferent_close(afferent_t* coprocessor) { delete coprocessor; }

const char* afferent_error(const afferent_t* coprocessor) {
    return coprocessor ? coprocessor->error.c_str() : open_error.c_str();
}

uint32_t afferent_addresses(const afferent_t* coprocessor) {
    return coprocessor ? coprocessor->scene.addresses() : 0;
}

uint32_t afferent_elements(const afferent_t* coprocessor) {
    return coprocessor ? coprocessor->scene.elements() : 0;
}

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

}  // extern "C"
