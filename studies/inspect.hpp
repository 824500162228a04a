// What a table is: its columns, rate, gaps and ranges, and a scene that runs on it.
//
//     auto inspected = inspect_table("six.csv");
//     if (inspected) run(inspected.value().scene);
//
// The command `afferent inspect` prints this, and Python hands it on.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/encoders/calibration.hpp"
#include "afferent/io/files/table.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// What a user knows better than the table says.
struct InspectionOptions {
    TableOptions table = {};
    // The unit of columns whose names have none.
    scene::TableUnit unit = scene::TableUnit::by_name;
    // From volts, or counts, to newtons: points whose `counts` are in the table's own unit.
    std::vector<Calibration::Point> calibration = {};
    std::optional<double> newtons_per_volt = {};
    // The voltage at which the converter reads its highest count.
    std::optional<double> reference_v = {};
    // Called while a table is read, with the part that is done.
    std::function<void(double fraction)> progress = {};
};

struct ColumnInspection {
    enum class Use { grip_force, element_force, emg, not_used };
    std::string name;
    Use use = Use::not_used;
    std::string unit = {};    // "newtons", "counts", "volts"; empty: not known
    std::string reason = {};  // why it is taken for that
    double lowest = 0;
    double highest = 0;
    double median = 0;
};

struct TableInspection {
    // Of a very long table its first rows, for which 64 MB are needed, and as much for looking at them.
    static constexpr std::size_t most_values = std::size_t{1} << 23U;

    Table table;
    std::vector<ColumnInspection> columns;
    std::vector<std::string> sentences;    // every decision, for people
    std::vector<std::string> assumptions;  // what nobody has said: to be checked
    double rate_hz = 0;                    // of the middle interval between rows
    Duration shortest_interval{};
    Duration longest_interval{};
    struct Gap {
        TimePoint begin;
        Duration length;
    };
    std::uint64_t gaps = 0;         // intervals of more than 1.5 times the middle one
    std::vector<Gap> longest_gaps;  // at most 10
    Duration length{};
    // Nothing: no column is a force; `why_no_scene` says what to do.
    std::optional<Scene> scene;
    std::string why_no_scene;
};

Result<TableInspection> inspect_table(const std::filesystem::path& file,
                                      const InspectionOptions& options = {});

// What is inspected already. The scene's table is named by this path.
TableInspection inspect(Table table, const std::string& path, const InspectionOptions& options = {});

// The scene of a table in a line. Throws SceneError where the table cannot be read, or has no force.
Scene scene_for(const std::filesystem::path& file, const InspectionOptions& options = {});

}  // namespace afferent
