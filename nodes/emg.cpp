#include "afferent/nodes/emg.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/io/files/table.hpp"
#include "afferent/nodes/emg_signal.hpp"
#include "afferent/nodes/table_gap.hpp"
#include "afferent/nodes/table_notes.hpp"
#include "afferent/scene/scene_table.hpp"

namespace afferent {
namespace {

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// Forces and EMG that one clock has stamped begin together, though each by itself would begin at its own
// first row. Returns what was done about it, if anything.
std::optional<std::string> begin_together(const Scene& scene, Table& emg) {
    const scene::Table* const forces = force_table(scene.source);
    const scene::EmgTable& asked = *scene.hand.emg_table;
    if (!forces || forces->begin_s || asked.begin_s || forces->rate_hz || asked.rate_hz) return std::nullopt;
    const auto span = force_table_span(scene);
    if (!span || span->format.begin == emg.format.begin || span->format.since_1970 != emg.format.since_1970)
        return std::nullopt;
    const Duration later = emg.format.begin - span->format.begin;
    const bool overlap = emg.times.front() + later <= span->last && emg.times.back() + later >= span->first;
    if (!overlap) return "EMG: its times are none of the table of forces, and it begins with it";
    std::size_t kept = 0;
    for (std::size_t i = 0; i < emg.rows(); ++i) {
        if (emg.times[i] + later < scene_start) continue;
        emg.times[kept] = emg.times[i] + later;
        emg.values[kept++] = emg.values[i];
    }
    emg.times.resize(kept);
    emg.values.resize(kept);
    return "EMG: by its clock it begins " + in_seconds(later < Duration::zero() ? -later : later) +
           (later > Duration::zero() ? " after" : " before") + " the forces";
}

}  // namespace

EmgSource::EmgSource(const Scene& scene, double rest_counts)
    : rate_hz_(scene.hand.emg_rate_hz),
      between_(scene.hand.emg_table.value_or(scene::EmgTable()).between),
      user_(scene.hand.user, scene.seed),
      rests_(!scene.hand.emg_table && traits_of(scene.source).measured &&
             scene.hand.user == User::Parameters()),
      rest_counts_(rest_counts),
      raw_{rest_counts, User::rest_counts} {
    if (rests_)
        said_.emplace_back("EMG: none beside the recorded force, so both muscles rest (--emg names a table)");
    else if (!scene.hand.emg_table && traits_of(scene.source).measured)
        said_.emplace_back("EMG: that of the scene's simulated user, beside a recorded force");
}

Result<EmgSource> EmgSource::open(const Scene& scene) {
    const auto& given = scene.hand.emg_table;
    if (!given) return of(scene, {});
    auto read = read_table(scene.resolve(given->path), table_options(*given));
    if (const auto* error = std::get_if<TableError>(&read))
        return Error{Error::Kind::malformed, error->message()};
    auto& table = std::get<Table>(read);
    const TableFormat format = table.format;
    const auto shift = begin_together(scene, table);
    EmgReading reading = read_emg(std::move(table), *given, scene.hand.envelope_ms);
    EmgSource source = of(scene, std::move(reading.table));
    if (!reading.said.empty()) source.said_.push_back(std::move(reading.said));
    if (format.missing.rows != 0) source.said_.push_back("EMG: " + format.said_of_missing());
    if (format.left_out_line != 0) source.said_.push_back("EMG: " + format.said_of_left_out_line());
    if (shift)
        source.said_.push_back(*shift);
    else if (format.begin != Duration::zero())
        source.said_.push_back("EMG: the table's time " + in_seconds(format.begin) + " is the scene's 0");
    if (const auto end = source.end(); end && *end + table_end_tolerance < scene.end())
        source.said_.push_back("EMG: the table ends at " + in_seconds(*end - scene_start) +
                               ", and the muscle rests from then on");
    return source;
}

EmgSource EmgSource::of(const Scene& scene, EmgTable table) {
    if (table.times.empty()) return EmgSource(scene, User::rest_counts);
    const auto& given = scene.hand.emg_table;
    const double rest = given->rest_counts  ? *given->rest_counts
                        : table.rest_counts ? *table.rest_counts
                                            : median(table.counts);
    EmgSource source(scene, rest);
    source.table_ = std::move(table);
    return source;
}

std::optional<TimePoint> EmgSource::end() const {
    return table_.times.empty() ? std::nullopt : std::optional(table_.times.back());
}

Emg EmgSource::sample(std::uint64_t k) noexcept {
    if (rests_) return {User::rest_counts, User::rest_counts};
    const TimePoint time = sample_time(k, rate_hz_);
    if (table_.times.empty()) return user_.emg(time, k);
    raw_.closing_counts = closing_counts(time);
    return raw_;
}

// Before the first row and after the last the muscle is at rest.
double EmgSource::closing_counts(TimePoint time) noexcept {
    const std::vector<TimePoint>& times = table_.times;
    while (next_ < times.size() && times[next_] <= time) ++next_;
    if (next_ == 0 || (next_ == times.size() && time > times.back())) return rest_counts_;
    const double row = table_.counts[next_ - 1];
    if (next_ == times.size()) return row;
    const TableGap gap{times[next_ - 1], times[next_]};
    if (gap.steps(from_seconds(1 / rate_hz_), between_) == 1) return row;
    return std::lerp(row, table_.counts[next_], gap.fraction(time));
}

}  // namespace afferent
