#include "afferent/studies/kept_results.hpp"

#include <algorithm>
#include <limits>
#include <string_view>

#include "afferent/runtime/overloaded.hpp"

namespace afferent {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

KeptDoubt kept(Doubt doubt) {
    KeptDoubt characters{};
    const std::string_view word = name(doubt);
    std::copy(word.begin(), word.end(), characters.begin());
    return characters;
}

std::int64_t ns(TimePoint time) { return (time - scene_start).count(); }

// Calls column(name, format, value) with the values as they are kept.
template <class Column>
void each_column(const PatchReadout& readout, const Column& column) {
    const Overloaded keep{
        [&](const char* name, TimePoint time) { column(name, "i8", ns(time)); },
        [&](const char* name, PatchIndex patch) { column(name, "u4", patch.value); },
        [&](const char* name, std::uint32_t count) { column(name, "u4", count); },
        [&](const char* name, double value) { column(name, "f8", value); },
        [&](const char* name, std::optional<double> value) { column(name, "f8", value.value_or(unknown)); }};
    std::visit([&](const auto& kind) { kind.columns(keep); }, readout);
}

}  // namespace

std::vector<KeptColumn> kept_columns(const PatchReadout& kind) {
    std::vector<KeptColumn> columns;
    std::size_t offset = 0;
    each_column(kind, [&](const char* name, const char* format, const auto& value) {
        columns.push_back({name, format, offset});
        offset += sizeof value;
    });
    return columns;
}

std::size_t kept_row_bytes(const PatchReadout& kind) {
    std::size_t bytes = 0;
    each_column(kind, [&](const char*, const char*, const auto& value) { bytes += sizeof value; });
    return bytes;
}

void KeptResults::expect_steps(std::size_t count, std::size_t parts_of_each) {
    steps.reserve(count);
    parts.reserve(count * parts_of_each);
}

void KeptResults::add(const ControllerStep& step) {
    const Estimate& estimate = step.estimate;
    doubts.add(estimate.doubt, step.time);
    steps.push_back({ns(step.time), step.true_force_n.value_or(unknown), estimate.force_n, estimate.sigma_n,
                     estimate.rate_hz, step.gain, step.closing_counts, step.effort.closing,
                     step.effort.opening, step.command, kept(estimate.doubt)});
    for (const PartForce& part : step.parts)
        parts.push_back({part.true_force_n.value_or(unknown), part.estimate.force_n, part.estimate.sigma_n,
                         kept(part.estimate.doubt)});
    for (const PatchReadout& readout : step.readouts) {
        std::vector<std::byte>& rows = readouts[readout.index()];
        each_column(readout, [&](const char*, const char*, const auto& value) {
            const auto bytes = std::as_bytes(std::span(&value, 1));
            rows.insert(rows.end(), bytes.begin(), bytes.end());
        });
    }
}

}  // namespace afferent
