#include "afferent/apps/link_status.hpp"

#include <cstdio>
#include <iostream>
#include <string>
#include <utility>

#include "afferent/apps/status_service.hpp"

namespace afferent {
namespace {

double number(const Summary& status, const char* key) {
    const Summary* found = status.find(key);
    return found ? found->number().value_or(0) : 0;
}

std::string word(const Summary& status, const char* key) {
    const Summary* found = status.find(key);
    return found && found->text() ? *found->text() : "";
}

// Per second. A process that has restarted counts from 0 again.
double rate(const Summary& before, const Summary& now, const char* key, double elapsed_s) {
    const double from = number(before, key);
    return (number(now, key) - (from > number(now, key) ? 0 : from)) / elapsed_s;
}

void show_channel(const Summary& before, const Summary& now, double elapsed_s) {
    std::printf("%-12s", "channel");
    for (const auto& [way, words] :
         {std::pair("to_hand", "to the hand"), std::pair("to_coprocessor", "back")}) {
        static const Summary none;
        const Summary* const from = before.find(way);
        const Summary* const to = now.find(way);
        const Summary& counts = to ? *to : none;
        std::printf("  %s %6.0f frames/s  lost %.0f  dropped %.0f  changed %.0f", words,
                    rate(from ? *from : none, counts, "frames", elapsed_s), number(counts, "lost"),
                    number(counts, "dropped"), number(counts, "corrupted"));
    }
    std::puts("");
}

void show_change(const std::string& link_end, const Summary& before, const Summary& now, double elapsed_s) {
    if (link_end == "channel") return show_channel(before, now, elapsed_s);
    if (!now.find("packets") || !before.find("packets"))
        return void(std::printf("%-12s %s\n", link_end.c_str(), word(now, "session").c_str()));
    const auto per_second = [&](const char* key) { return rate(before, now, key, elapsed_s); };
    std::printf("%-12s %8.2f s  %-10s %6.0f packets/s %8.0f events/s %8.2f kB/s", link_end.c_str(),
                number(now, "at_s"), word(now, "session").c_str(), per_second("packets"),
                per_second("events"), per_second("bytes") / 1e3);
    if (now.find("gain"))
        std::printf("  gaps %.0f  lost %.0f  %s  %5.2f N  gain %.2f", number(now, "gaps"),
                    number(now, "lost_events"), word(now, "grip_state").c_str(), number(now, "force_n"),
                    number(now, "gain"));
    else
        std::printf("  dropped %.0f", number(now, "dropped_packets"));
    std::puts("");
}

}  // namespace

Summary ask_ends(const Scene& scene) {
    Summary all;
    for (const char* link_end : {"coprocessor", "channel", "hand"})
        if (auto status = ask_status(scene, link_end)) all[link_end] = *std::move(status);
    return all;
}

void show_ends(const Summary& link_ends) {
    for (const auto& [link_end, status] : link_ends.entries()) {
        std::cout << link_end << '\n';
        print(status);
    }
}

void show_changes(const Summary& before, const Summary& now, double elapsed_s) {
    for (const auto& [link_end, status] : now.entries())
        if (const Summary* last = before.find(link_end)) show_change(link_end, *last, status, elapsed_s);
}

}  // namespace afferent
