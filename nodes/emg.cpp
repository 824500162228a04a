#include "afferent/nodes/emg.hpp"

#include <algorithm>

#include "afferent/io/files/table.hpp"
#include "afferent/scene/parameters.hpp"

namespace afferent {
namespace {

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

EmgEnvelope::Parameters of_user(const proto::Hand& hand) {
    return {hand.envelope_ms(), User::rest_counts, User::full_scale_counts};
}

}  // namespace

EmgSource::EmgSource(const Scene& scene, EmgEnvelope::Parameters closing)
    : rate_hz_(scene.description().hand().emg_rate_hz()),
      user_(user_parameters(scene.description().hand().user()), scene.seed()),
      closing_(closing, from_seconds(1 / rate_hz_)),
      opening_(of_user(scene.description().hand()), from_seconds(1 / rate_hz_)),
      rest_counts_(closing.rest_counts),
      raw_{closing.rest_counts, User::rest_counts} {}

Result<EmgSource> EmgSource::open(const Scene& scene) {
    const proto::Hand& hand = scene.description().hand();
    if (!hand.has_emg_table()) return of(scene, {});
    auto read = read_table(scene.resolve(hand.emg_table().path()), {hand.emg_table().column()});
    if (const auto* error = std::get_if<TableError>(&read))
        return Error{Error::Kind::malformed, error->message()};
    auto& table = std::get<Table>(read);
    return of(scene, {std::move(table.times), std::move(table.values)});
}

EmgSource EmgSource::of(const Scene& scene, EmgTable table) {
    const proto::Hand& hand = scene.description().hand();
    if (table.times.empty()) return EmgSource(scene, of_user(hand));
    const double rest =
        hand.emg_table().has_rest_counts() ? hand.emg_table().rest_counts() : median(table.counts);
    EmgSource source(scene, {hand.envelope_ms(), rest, hand.emg_table().full_scale_counts()});
    source.table_ = std::move(table);
    return source;
}

Effort EmgSource::sample(std::uint64_t k) noexcept {
    const TimePoint time = sample_time(k, rate_hz_);
    if (table_.times.empty()) {
        raw_ = user_.emg(time, k);
        return {closing_(raw_.closing_counts), opening_(raw_.opening_counts)};
    }
    // Each recorded sample is held until the next; before the first and after the last the muscle is at rest.
    const std::vector<TimePoint>& times = table_.times;
    while (next_ < times.size() && times[next_] <= time) raw_.closing_counts = table_.counts[next_++];
    if (next_ == times.size() && time > times.back()) raw_.closing_counts = rest_counts_;
    return {closing_(raw_.closing_counts), 0};
}

}  // namespace afferent
