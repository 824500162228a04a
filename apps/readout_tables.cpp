#include "afferent/apps/readout_tables.hpp"

#include <string_view>

#include "afferent/runtime/overloaded.hpp"

namespace afferent {
namespace {

// Calls `call` with each table, whose kind it is.
void each(auto& tables, auto&& call) {
    std::apply([&](auto&... table) { (call(table), ...); }, tables.all);
}

// Times are in seconds, as everywhere in tables.
std::vector<std::string> columns_of(const auto& row) {
    std::vector<std::string> names;
    row.columns([&]<class T>(const char* name, const T&) {
        names.push_back(std::is_same_v<T, TimePoint> ? std::string(name) + "_s" : name);
    });
    return names;
}

}  // namespace

ReadoutTables::ReadoutTables(const Plan& plan) : plan_(plan) {
    if (!plan.controller) return;
    for (const ReadoutParameters& parameters : plan.controller->readouts.parameters)
        each(tables_, [&]<class Kind>(Table<Kind>& table) {
            if (const auto* of_kind = std::get_if<typename Kind::Parameters>(&parameters))
                table.totals[of_kind->patch.value];
        });
}

std::vector<std::string> ReadoutTables::names() {
    std::vector<std::string> names;
    TablesOf<Readouts::Any> none;
    each(none,
         [&]<class Kind>(Table<Kind>&) { names.push_back(std::string(Kind::Readout::table) + ".csv"); });
    return names;
}

void ReadoutTables::open(const std::filesystem::path& folder, FullPipe full_pipe) {
    each(tables_, [&]<class Kind>(Table<Kind>& table) {
        if (table.totals.empty()) return;
        const auto names = columns_of(typename Kind::Readout());
        table.writer.emplace(folder / (std::string(Kind::Readout::table) + ".csv"),
                             std::vector<std::string_view>(names.begin(), names.end()), full_pipe);
    });
}

void ReadoutTables::step(const ControllerStep& step) {
    for (const PatchReadout& readout : step.readouts)
        each(tables_, [&]<class Kind>(Table<Kind>& table) {
            const auto* row = std::get_if<typename Kind::Readout>(&readout);
            if (!row) return;
            table.totals.at(row->patch.value).add(*row);
            if (!table.writer) return;
            const Overloaded write{
                [&](TimePoint time) { table.writer->cell(time); },
                [&](PatchIndex patch) { table.writer->text(plan_.patches[patch.value].name); },
                [&](std::uint32_t count) { table.writer->cell(std::uint64_t{count}); },
                [&](double value) { table.writer->cell(value); },
                [&](std::optional<double> value) {
                    if (value)
                        table.writer->cell(*value);
                    else
                        table.writer->no_value();
                }};
            row->columns([&](const char*, const auto& value) { write(value); });
            table.writer->end_row();
        });
}

void ReadoutTables::add_to(Summary& summary) const {
    each(tables_, [&](const auto& table) {
        for (const auto& [patch, totals] : table.totals) totals.add_to(summary, plan_.patches[patch].name);
    });
}

std::vector<std::optional<TableWriter>*> ReadoutTables::writers() {
    std::vector<std::optional<TableWriter>*> all;
    each(tables_, [&](auto& table) { all.push_back(&table.writer); });
    return all;
}

bool ReadoutTables::failed() const {
    bool failed = false;
    each(tables_, [&](const auto& table) { failed = failed || (table.writer && table.writer->error()); });
    return failed;
}

}  // namespace afferent
