#include "afferent/nodes/emg.hpp"

#include <algorithm>

#include "afferent/io/files/table.hpp"

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
    // Each recorded sample is held until the next; before the first and after the last the muscle is at rest.
    const std::vector<TimePoint>& times = table_.times;
    while (next_ < times.size() && times[next_] <= time) raw_.closing_counts = table_.counts[next_++];
    if (next_ == times.size() && time > times.back()) raw_.closing_counts = rest_counts_;
    return raw_;
}

}  // namespace afferent
