#include "afferent/scene/scene_table.hpp"

#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

namespace afferent {
namespace {

template <class T>
TableOptions common_options(const T& table) {
    TableOptions options{.columns = {},
                         .time_column = table.time_column,
                         .time_unit = table.time_unit,
                         .missing = table.missing};
    if constexpr (requires { table.rate_hz; }) {
        options.rate_hz = table.rate_hz;
        if (table.begin_s)
            options.begin = Duration(std::llround(static_cast<long double>(*table.begin_s) * 1e9L));
    }
    return options;
}

}  // namespace

TableOptions table_options(const scene::Table& table) {
    TableOptions options = common_options(table);
    options.columns = table.column;
    return options;
}

TableOptions table_options(const scene::StandardInput& input) {
    TableOptions options = common_options(input);
    options.columns = input.column;
    return options;
}

TableOptions table_options(const scene::EmgTable& table) {
    TableOptions options = common_options(table);
    options.columns = {table.column};
    return options;
}

std::optional<TableSpan> force_table_span(const Scene& scene, const std::function<void(double)>& progress) {
    const scene::Table* const table = force_table(scene.source);
    if (!table) return std::nullopt;
    const std::filesystem::path file = scene.resolve(table->path);
    std::error_code failure;
    if (!std::filesystem::is_regular_file(file, failure)) return std::nullopt;
    auto read = read_span(file, table_options(*table), progress);
    if (auto* span = std::get_if<TableSpan>(&read)) return std::move(*span);
    return std::nullopt;
}

double default_duration_s(const Scene& scene, const std::function<void(double)>& progress) {
    const auto span = force_table_span(scene, progress);
    // A table of one row at 0 has no length.
    return span && span->length() > Duration::zero() ? seconds(span->length()) : scene::default_duration_s;
}

}  // namespace afferent
