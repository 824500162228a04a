#include "afferent/nodes/emg.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/io/files/table.hpp"
#include "afferent/nodes/table_gap.hpp"

namespace afferent {
namespace {

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

EmgSource::EmgSource(const Scene& scene, double rest_counts)
    : rate_hz_(scene.hand.emg_rate_hz),
      between_(scene.hand.emg_table.value_or(scene::EmgTable()).between),
      user_(scene.hand.user, scene.seed),
      rest_counts_(rest_counts),
      raw_{rest_counts, User::rest_counts} {}

Result<EmgSource> EmgSource::open(const Scene& scene) {
    const auto& given = scene.hand.emg_table;
    if (!given) return of(scene, {});
    auto read = read_table(scene.resolve(given->path), {given->column});
    if (const auto* error = std::get_if<TableError>(&read))
        return Error{Error::Kind::malformed, error->message()};
    auto& table = std::get<Table>(read);
    return of(scene, {std::move(table.times), std::move(table.values)});
}

EmgSource EmgSource::of(const Scene& scene, EmgTable table) {
    if (table.times.empty()) return EmgSource(scene, User::rest_counts);
    const auto& given = scene.hand.emg_table;
    EmgSource source(scene, given->rest_counts ? *given->rest_counts : median(table.counts));
    source.table_ = std::move(table);
    return source;
}

Emg EmgSource::sample(std::uint64_t k) noexcept {
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
