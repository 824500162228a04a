// What a scene's address-event bus has done, for a summary.
#pragma once

#include "afferent/apps/summary.hpp"
#include "afferent/io/event_bus.hpp"

namespace afferent {

// Nothing where there is no bus.
inline void add_bus(Summary& summary, const EventBus* bus) {
    if (!bus) return;
    const auto delay_us = [&](double share) { return static_cast<double>(bus->delay(share).count()) / 1e3; };
    summary["bus_events"] = bus->counts().events;
    summary["bus_collisions"] = bus->counts().collisions;
    summary["bus_dropped"] = bus->counts().dropped;
    summary["bus_delay_p50_us"] = delay_us(0.5);
    summary["bus_delay_p99_us"] = delay_us(0.99);
    summary["bus_delay_max_us"] = delay_us(1);
}

}  // namespace afferent
