#include "afferent/view/portion.hpp"

namespace afferent {
namespace {

constexpr std::size_t most_gaps = 500;
constexpr std::size_t most_notes = 100;

template <class Items>
void append_to(Items& items, const Items& later) {
    items.insert(items.end(), later.begin(), later.end());
}

// Items come in the order of time.
template <class Items, class TimeOf>
void drop_old(Items& items, Duration span, const TimeOf& time_of) {
    if (items.empty()) return;
    const TimePoint from = time_of(items.back()) - span;
    while (time_of(items.front()) < from) items.pop_front();
}

}  // namespace

void Portion::append(const Portion& later) {
    append_to(samples, later.samples);
    append_to(raster, later.raster);
    append_to(gaps, later.gaps);
    append_to(link_points, later.link_points);
    append_to(notes, later.notes);
    if (later.link) link = later.link;
}

void Portion::keep_last(Duration span, Duration bin) {
    const auto time = [](const auto& item) { return item.time; };
    drop_old(samples, span, time);
    drop_old(link_points, span, time);
    drop_old(raster, span, [bin](const RasterRun& run) { return scene_start + run.first_bin * bin; });
    while (gaps.size() > most_gaps) gaps.pop_front();
    while (notes.size() > most_notes) notes.pop_front();
}

}  // namespace afferent
