#include "afferent/apps/drive_table.hpp"

#include <utility>
#include <variant>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/table.hpp"

namespace afferent {
namespace {

// Where a storm of spikes is cut off.
constexpr std::size_t default_max_spikes = 10'000'000;

TimePoint end_of(const DriveTable& table, const bench::Workload& workload) {
    if (table.until_s > 0) return scene_start + rounded(Seconds(table.until_s));
    if (table.max_spikes > 0) return workload.times.back() + rounded(Seconds(1e6));
    if (workload.rows() > 1) return workload.times.back();
    throw Failure("a table of one row needs --until-s or --max-spikes");
}

}  // namespace

bench::Workload workload(const DriveTable& table) {
    auto read = read_table(table.file);
    if (const auto* error = std::get_if<TableError>(&read)) throw Failure(error->message());
    Table& drives = std::get<Table>(read);
    table.parameters.check();

    bench::Workload result;
    result.name = drives.file;
    result.parameters = {table.parameters};
    result.neurons = drives.columns.size();
    if (result.neurons == 0) throw Failure(drives.file + ": needs a drive column beside time_s");
    result.times = std::move(drives.times);
    result.drives_mv = std::move(drives.values);
    result.max_spikes = table.max_spikes > 0 ? table.max_spikes : default_max_spikes;
    // Before the first row the drive is 0.
    if (result.times.front() > scene_start) {
        result.times.insert(result.times.begin(), scene_start);
        result.drives_mv.insert(result.drives_mv.begin(), result.neurons, 0.0);
    }
    result.until = end_of(table, result);
    while (result.rows() > 1 && result.times.back() >= result.until) {
        result.times.pop_back();
        result.drives_mv.resize(result.rows() * result.neurons);
    }
    return result;
}

}  // namespace afferent
