#include "afferent/studies/inspect.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <system_error>

#include "afferent/io/files/column_unit.hpp"
#include "afferent/nodes/emg_signal.hpp"
#include "afferent/scene/scene_error.hpp"
#include "afferent/scene/scene_table.hpp"

namespace afferent {
namespace {

using Use = ColumnInspection::Use;

// A force-sensing resistor of half an inch (Interlink FSR 402): points of the force–resistance curve of its
// integration guide, read off to about 20 %. On log–log axes the curve is nearly straight between them.
struct ForceOfResistance {
    double force_n;
    double ohm;
};
constexpr std::array fsr_402{ForceOfResistance{0.2, 30'000}, ForceOfResistance{1, 6'000},
                             ForceOfResistance{10, 1'000}, ForceOfResistance{100, 250}};
constexpr double fsr_pull_down_ohm = 10'000;

constexpr unsigned bits_of_volts = 12;  // as counts, in which volts are calibrated
constexpr double usual_reference_v = 5;
constexpr double lower_reference_v = 3.3;
constexpr std::size_t most_gaps_told = 10;
// Rows that are farther apart than this many middle intervals have a gap between them.
constexpr double longest_regular = 1.5;
constexpr double slowest_sensor_hz = 100;
// A column is the sum of the others if it differs from it by no more than this fraction of itself (RMS), and
// may be meant as one up to the other.
constexpr double sum_tolerance = 0.01;
constexpr double near_sum_tolerance = 0.2;
// Less than this is the rounding of a sum.
constexpr double rounding = 1e-12;
// The default gain is for grips of up to this force.
constexpr double usual_range_n = 20;

std::string to_text(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", value);
    return text.data();
}

// 1, 2 or 5 times a power of ten that is not below the value.
double rounded_up(double value) {
    if (!(value > 0)) return 1;
    const double power = std::pow(10, std::floor(std::log10(value)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= value * (1 - 1e-9)) return factor * power;
    return 10 * power;
}

double middle(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// What a column is in where neither its name nor the user says so: converters give whole numbers.
bool looks_like_counts(const Table& table, std::size_t column) {
    double highest = 0;
    for (std::size_t i = 0; i < table.rows(); ++i) {
        const double value = table.row(i)[column];
        if (value < 0 || value != std::floor(value)) return false;
        highest = std::max(highest, value);
    }
    return highest >= 64;
}

bool is_called_emg(const std::string& name) {
    return name.find("emg") != std::string::npos || name.find("electrode") != std::string::npos;
}

class Inspector {
  public:
    Inspector(Table table, const std::string& path, const InspectionOptions& options)
        : options_(options), path_(path) {
        found_.table = std::move(table);
    }

    TableInspection result() {
        found_.sentences = found_.table.format.sentences();
        if (table().format.is_cut)
            assume("The table is long, and only its first " + std::to_string(table().rows()) +
                   " rows, up to " + to_text(seconds(table().span().last)) +
                   " s, are looked at: what comes later is taken to be alike. A run reads all of it.");
        inspect_times();
        for (std::size_t i = 0; i < table().columns.size(); ++i) inspect_column(i);
        choose();
        if (found_.why_no_scene.empty()) check_signs();
        if (found_.why_no_scene.empty()) make_scene();
        return std::move(found_);
    }

  private:
    const Table& table() const { return found_.table; }
    void say(std::string sentence) { found_.sentences.push_back(std::move(sentence)); }
    void assume(std::string sentence) { found_.assumptions.push_back(std::move(sentence)); }

    void inspect_times() {
        const auto& times = table().times;
        found_.length = table().span().length();
        if (times.size() < 2) return;
        std::vector<double> intervals;
        for (std::size_t i = 1; i < times.size(); ++i)
            intervals.push_back(static_cast<double>((times[i] - times[i - 1]).count()));
        const auto [shortest, longest] = std::ranges::minmax_element(intervals);
        found_.shortest_interval = rounded(Interval(*shortest));
        found_.longest_interval = rounded(Interval(*longest));
        const double usual = middle(intervals);
        found_.rate_hz = 1e9 / usual;
        for (std::size_t i = 1; i < times.size(); ++i) {
            const Duration interval = times[i] - times[i - 1];
            if (static_cast<double>(interval.count()) <= longest_regular * usual) continue;
            ++found_.gaps;
            found_.longest_gaps.push_back({times[i - 1], interval});
        }
        auto& gaps = found_.longest_gaps;
        const std::size_t told = std::min(gaps.size(), most_gaps_told);
        std::ranges::partial_sort(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(told),
                                  std::ranges::greater(), &TableInspection::Gap::length);
        gaps.resize(told);
    }

    void inspect_column(std::size_t index) {
        ColumnInspection column{.name = table().columns[index]};
        std::vector<double> values(table().rows());
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = table().row(i)[index];
        const auto [lowest, highest] = std::ranges::minmax_element(values);
        column.lowest = *lowest;
        column.highest = *highest;
        column.median = middle(std::move(values));
        const NamedUnit named = named_unit(column.name);
        std::optional<ValueUnit> unit = value_unit(named.unit);
        if (unit) {
            column.reason = "its name says so";
        } else if (const std::string mass = said_of_mass(column.name); !mass.empty()) {
            column.reason = mass;
        } else if (!named.unit.empty()) {
            column.reason = "its unit, " + named.unit + ", is none of force, counts or volts";
        } else if (options_.unit != scene::TableUnit::by_name) {
            unit = ValueUnit{options_.unit == scene::TableUnit::newtons  ? Quantity::force
                             : options_.unit == scene::TableUnit::counts ? Quantity::counts
                                                                         : Quantity::volts,
                             1};
            column.reason = "it is said";
        } else if (looks_like_counts(table(), index)) {
            unit = ValueUnit{Quantity::counts, 1};
            column.reason = "its numbers are whole and not negative";
            guesses_counts_ = guesses_counts_ || !is_called_emg(named.name);
        } else {
            column.reason = "its name has no unit: say --unit newtons or --unit volts";
        }
        if (unit) column.unit = unit_name(unit->quantity);
        const bool emg = is_called_emg(named.name) && !(unit && unit->quantity == Quantity::force);
        if (emg) {
            column.use = Use::emg;
            column.reason = "its name says so";
        }
        units_.push_back(unit);
        found_.columns.push_back(std::move(column));
    }

    // Columns of force go before those of volts, and those before counts.
    void choose() {
        for (const Quantity quantity : {Quantity::force, Quantity::volts, Quantity::counts}) {
            for (std::size_t i = 0; i < units_.size(); ++i)
                if (units_[i] && units_[i]->quantity == quantity && found_.columns[i].use != Use::emg)
                    used_.push_back(i);
            if (used_.empty()) continue;
            quantity_ = quantity;
            break;
        }
        const bool is_grip = used_.size() == 1 && quantity_ == Quantity::force;
        for (const std::size_t i : used_)
            found_.columns[i].use = is_grip ? Use::grip_force : Use::element_force;
        for (ColumnInspection& column : found_.columns)
            if (column.use == Use::not_used && !column.unit.empty())
                column.reason = std::string("the columns in ") + unit_name(quantity_) + " are the forces";
        const bool has_emg =
            std::ranges::find(found_.columns, Use::emg, &ColumnInspection::use) != found_.columns.end();
        leave_out_sum();
        if (used_.empty() && has_emg)
            found_.why_no_scene =
                "it has EMG, and no column that is known to be a force. EMG is given beside a scene: "
                "afferent run SCENE --emg "
                "FILE. If there are forces, say what they are in (--unit newtons, counts or volts)";
        else if (const std::string mass = first_mass(); used_.empty() && !mass.empty())
            found_.why_no_scene = "no column is a force: " + mass;
        else if (used_.empty())
            found_.why_no_scene =
                "no column is known to be a force. Say what columns are in whose names have no unit (--unit "
                "newtons, "
                "counts or volts), and which are forces (--columns)";
    }

    // What to do about the first column of masses; empty: there is none.
    std::string first_mass() const {
        for (const ColumnInspection& column : found_.columns)
            if (std::string mass = said_of_mass(column.name); !mass.empty()) return mass;
        return "";
    }

    // A column that is the sum of the others is no sensor, and counted as one it would double the force.
    void leave_out_sum() {
        if (quantity_ != Quantity::force) return;
        const auto changing = std::ranges::count_if(used_, [this](std::size_t i) { return changes(i); });
        if (changing < 3) return;
        for (const std::size_t candidate : used_) {
            if (!changes(candidate)) continue;
            const Difference differs = difference_from_sum(candidate);
            if (differs.relative > near_sum_tolerance) continue;
            ColumnInspection& column = found_.columns[candidate];
            const std::string within =
                " the sum of the other forces" +
                (differs.relative > rounding ? ", within " + to_text(differs.largest_n) + " N" : "");
            if (differs.relative > sum_tolerance) {
                assume("Column \"" + column.name + "\" is a sensor of its own, although it is nearly" +
                       within + ". If it is their sum, it doubles the force: name the others by --columns.");
                continue;
            }
            column.use = Use::not_used;
            column.reason = "it is the sum of the others: a check, and no sensor";
            std::erase(used_, candidate);
            return say("Column \"" + column.name + "\" is" + within +
                       ": it is a check of them, and no sensor of its own.");
        }
    }

    // Of a column from the sum of the other forces.
    struct Difference {
        double largest_n;
        double relative;  // RMS of the difference over that of the column
    };
    Difference difference_from_sum(std::size_t candidate) const {
        const auto force_n = [this](std::size_t row, std::size_t i) {
            return units_[i]->factor * table().row(row)[i];
        };
        double largest = 0;
        double differences = 0;
        double squares = 0;
        for (std::size_t row = 0; row < table().rows(); ++row) {
            double sum_n = 0;
            for (const std::size_t i : used_)
                if (i != candidate) sum_n += force_n(row, i);
            const double value_n = force_n(row, candidate);
            const double difference_n = sum_n - value_n;
            largest = std::max(largest, std::abs(difference_n));
            differences += difference_n * difference_n;
            squares += value_n * value_n;
        }
        return {largest, std::sqrt(differences / squares)};
    }

    bool changes(std::size_t column) const {
        return found_.columns[column].highest > found_.columns[column].lowest;
    }

    // Pressing cannot give a force below 0, unless its sign is reversed or its zero is wrong.
    void check_signs() {
        const auto negative = [this](std::size_t i) {
            return found_.columns[i].lowest < 0 && -found_.columns[i].lowest > found_.columns[i].highest;
        };
        std::string names;
        for (const std::size_t i : used_)
            if (negative(i)) names += (names.empty() ? "\"" : ", \"") + found_.columns[i].name + '"';
        if (names.empty()) return;
        const bool all =
            std::ranges::all_of(used_, [this](std::size_t i) { return found_.columns[i].highest <= 0; });
        if (all)
            found_.why_no_scene =
                "all forces are negative, or 0: is the sign reversed? A force that presses "
                "is positive; what is below 0 reads as 0";
        else
            assume("The forces of " + names +
                   " are farther below 0 than above it: is the sign reversed, or the zero wrong? What is "
                   "below 0 reads as 0.");
    }

    // Whether a column never changes while another does: a dead sensor, which is left out.
    bool is_dead(std::size_t column) const {
        return !changes(column) && std::ranges::any_of(used_, [this](std::size_t i) { return changes(i); });
    }

    // It has no share, and reads nothing, whatever the column says.
    void leave_out_dead(scene::Patch& patch) {
        for (std::uint32_t i = 0; i < used_.size(); ++i) {
            if (!is_dead(used_[i])) continue;
            patch.sensor.dead_element.push_back(i);
            say("Column \"" + found_.columns[used_[i]].name +
                "\" never changes: it is taken for a dead sensor, and left out (share 0).");
        }
    }

    // The highest value of the used columns, in newtons, counts or volts.
    double highest_value() const {
        double highest = 0;
        for (const std::size_t i : used_)
            highest = std::max(highest, units_[i]->factor * found_.columns[i].highest);
        return highest;
    }

    void make_scene() {
        Scene scene;
        const std::filesystem::path path(path_);
        scene.name = path.stem().stem().string();
        scene::Table source{.path = path_,
                            .column = {},
                            .time_column = options_.table.time_column,
                            .time_unit = options_.table.time_unit,
                            .rate_hz = options_.table.rate_hz,
                            .unit = options_.unit,
                            .missing = options_.table.missing};
        if (options_.table.begin) source.begin_s = seconds(*options_.table.begin);
        if (source.unit == scene::TableUnit::by_name && guesses_counts_ && quantity_ == Quantity::counts)
            source.unit = scene::TableUnit::counts;
        if (used_.size() < table().columns.size() || !options_.table.columns.empty() || is_container(path))
            for (const std::size_t i : used_) source.column.push_back(folder() + table().columns[i]);
        const bool is_grip = used_.size() == 1 && quantity_ == Quantity::force;
        scene.patches = {
            {.name = is_grip ? "grip" : "sensors", .elements = static_cast<std::uint32_t>(used_.size())}};
        for (scene::Patch& patch : scene.patches) set_sensor(patch.sensor);
        set_full_scales(scene);
        if (is_grip)
            say("One column of force is read by one element and one neuron: more would tell the same.");
        else
            leave_out_dead(scene.patches.front());
        fit_gain(scene);
        scene.source = std::move(source);
        // The filter knows best how a grip moves that all elements share. Sensors that are pressed one
        // without the other are no such shares, and are estimated each by itself.
        if (is_grip)
            scene.decoder.kind = scene::Filter();
        else
            scene.decoder.kind = scene::InverseInterval();
        set_emg(scene);
        // So that the same scene is recorded, and run on two machines.
        scene.link.transport = scene::Tcp();
        try {
            scene.check();
        } catch (const SceneError& error) {
            found_.why_no_scene = error.what();
            return;
        }
        found_.scene = std::move(scene);
    }

    // The group of an HDF5 file that the columns lie in.
    std::string folder() const {
        const std::string& path =
            options_.table.columns.empty() ? options_.table.time_column : options_.table.columns.front();
        return is_container(path_) ? path.substr(0, path.rfind('/') + 1) : "";
    }

    void set_sensor(scene::Sensor& sensor) {
        if (found_.rate_hz >= slowest_sensor_hz)
            sensor.rate_hz = std::stod(to_text(std::min(found_.rate_hz, 1e6)));
        if (quantity_ == Quantity::force) return;
        if (quantity_ == Quantity::volts) {
            sensor.adc_bits = bits_of_volts;
            sensor.reference_v = options_.reference_v.value_or(
                highest_value() <= lower_reference_v ? lower_reference_v : usual_reference_v);
        } else {
            sensor.adc_bits = 8;
            while (sensor.adc_bits < 24 && highest_value() > std::pow(2, sensor.adc_bits) - 1)
                sensor.adc_bits += sensor.adc_bits < 16 ? 2 : 8;
            sensor.reference_v = options_.reference_v.value_or(usual_reference_v);
        }
        set_calibration(sensor);
    }

    void set_calibration(scene::Sensor& sensor) {
        const double highest_count = std::pow(2, sensor.adc_bits) - 1;
        const double counts_per_volt = highest_count / sensor.reference_v;
        const double counts_per_unit = quantity_ == Quantity::volts ? counts_per_volt : 1;
        for (const Calibration::Point& point : options_.calibration)
            sensor.calibration.push_back({point.counts * counts_per_unit, point.force_n});
        if (options_.newtons_per_volt)
            sensor.calibration = {{0, 0}, {highest_count, *options_.newtons_per_volt * sensor.reference_v}};
        if (!sensor.calibration.empty()) return;
        // Along the curve, ten points for each factor of ten in force.
        sensor.calibration.push_back({0, 0});
        for (std::size_t i = 0; i + 1 < fsr_402.size(); ++i)
            for (int step = 0; step < 10; ++step) {
                const auto& [force_n, ohm] = fsr_402[i];
                const double part = step / 10.0;
                add_fsr_point(sensor, force_n * std::pow(fsr_402[i + 1].force_n / force_n, part),
                              ohm * std::pow(fsr_402[i + 1].ohm / ohm, part), highest_count);
            }
        add_fsr_point(sensor, fsr_402.back().force_n, fsr_402.back().ohm, highest_count);
        if (assumed_fsr_) return;
        assumed_fsr_ = true;
        assume(
            "Each column is taken for a force-sensing resistor of half an inch (Interlink FSR 402: 30 kOhm "
            "at 0.2 N, 6 "
            "kOhm at 1 N, 1 kOhm at 10 N, 250 Ohm at 100 N) with 10 kOhm to ground" +
            (quantity_ == Quantity::volts && !options_.reference_v
                 ? " at a supply of " + to_text(sensor.reference_v) + " V" +
                       (sensor.reference_v == lower_reference_v ? ", because no value is above that" : "")
                 : std::string()) +
            ". Such sensors differ by a quarter. With your own: --calibration 0:0,1.2:0.5,3:4 (" +
            (quantity_ == Quantity::volts ? "volts" : "counts") + ":newtons)" +
            (quantity_ == Quantity::volts ? ", --newtons-per-volt or --reference-v." : "."));
        if (quantity_ == Quantity::counts)
            assume("The converter is taken to have " + std::to_string(sensor.adc_bits) +
                   " bits, because no value is above " + to_text(highest_count) + ".");
    }

    static void add_fsr_point(scene::Sensor& sensor, double force_n, double ohm, double highest_count) {
        const double counts = highest_count * fsr_pull_down_ohm / (fsr_pull_down_ohm + ohm);
        // Written with as many digits as are known.
        sensor.calibration.push_back(
            {std::round(10 * counts) / 10, std::stod(to_text(std::round(force_n * 1e4) / 1e4))});
    }

    // Full scale of the sensors, and the force at which neurons fire at their highest rate.
    void set_full_scales(Scene& scene) const {
        const scene::Sensor& first = scene.patches.front().sensor;
        double highest_n = 0;
        double grip_n = 0;
        const std::optional<Calibration> calibration =
            quantity_ == Quantity::force ? std::nullopt : std::optional<Calibration>(first.calibration);
        const double counts_per_unit =
            quantity_ == Quantity::volts ? (std::pow(2, first.adc_bits) - 1) / first.reference_v : 1;
        const auto force_n = [&](std::size_t column, double value) {
            value *= units_[column]->factor * counts_per_unit;
            return calibration ? calibration->force_n(value) : std::max(value, 0.0);
        };
        // The sum of the columns' highest forces is no less than their highest sum.
        for (const std::size_t i : used_) {
            if (is_dead(i)) continue;
            const double column_n = force_n(i, found_.columns[i].highest);
            highest_n = std::max(highest_n, column_n);
            grip_n += column_n;
        }
        for (scene::Patch& patch : scene.patches) {
            patch.sensor.full_scale_n = rounded_up(std::clamp(highest_n, 0.01, 1e5));
            patch.neuron.tuning.force_n = rounded_up(std::clamp(grip_n, 0.1, 1e5));
            patch.neuron.tuning.begin_force_n = 0.015 * patch.neuron.tuning.force_n;
        }
        if (used_.size() > 1) set_shares(scene.patches.front(), force_n);
    }

    // A recording of a light grip needs a gain that goes to 0 sooner. That of a strong one, or one whose unit
    // is not what its name says, is no reason to let a hand press harder.
    void fit_gain(Scene& scene) {
        const double factor = scene.patches.front().neuron.tuning.force_n / usual_range_n;
        if (factor >= 1) return;
        for (double* force_n : {&scene.gain.onset_n, &scene.gain.lambda_n, &scene.gain.limit_n})
            *force_n = std::stod(to_text(*force_n * factor));
        say("The gain falls from " + to_text(scene.gain.onset_n) + " N on, and is 0 at " +
            to_text(scene.gain.limit_n) +
            " N, in proportion to the range: gain { limit_n } is what your object bears.");
    }

    // The shares of the sum that fit the columns best, as calibrate() has them: Σ f F / Σ F².
    template <class ForceOf>
    void set_shares(scene::Patch& patch, const ForceOf& force_n) const {
        std::vector<double> products(used_.size(), 0);
        std::vector<double> forces_n(used_.size());
        double squares = 0;
        for (std::size_t row = 0; row < table().rows(); ++row) {
            for (std::size_t i = 0; i < used_.size(); ++i)
                forces_n[i] = is_dead(used_[i]) ? 0 : force_n(used_[i], table().row(row)[used_[i]]);
            const double sum_n = std::accumulate(forces_n.begin(), forces_n.end(), 0.0);
            squares += sum_n * sum_n;
            for (std::size_t i = 0; i < used_.size(); ++i) products[i] += forces_n[i] * sum_n;
        }
        if (!(squares > 0) || !std::isfinite(squares)) return;
        // In whole parts of a million, rounded down, so that they do not add up to more than 1.
        for (const double product : products)
            patch.share.push_back(std::floor(1e6 * product / squares) / 1e6);
        const double sum = std::accumulate(patch.share.begin(), patch.share.end(), 0.0);
        if (sum > 1) patch.share.clear();
    }

    void set_emg(Scene& scene) {
        const auto found = std::ranges::find(found_.columns, Use::emg, &ColumnInspection::use);
        if (found == found_.columns.end()) {
            say("It has no EMG: the scene's user is at rest.");
            return;
        }
        const auto& source = *force_table(scene.source);
        scene.hand.emg_table = scene::EmgTable{.path = path_,
                                               .column = folder() + found->name,
                                               .time_column = source.time_column,
                                               .time_unit = source.time_unit,
                                               .rate_hz = source.rate_hz,
                                               .begin_s = source.begin_s,
                                               .missing = source.missing};
        const auto index = static_cast<std::size_t>(found - found_.columns.begin());
        Table emg{.file = table().file, .columns = {found->name}, .times = table().times, .values = {}};
        for (std::size_t i = 0; i < table().rows(); ++i) emg.values.push_back(table().row(i)[index]);
        const std::string said = read_emg(std::move(emg), *scene.hand.emg_table, scene.hand.envelope_ms).said;
        say(said.empty() ? "EMG: column \"" + found->name + "\" is in counts, and is taken as it is."
                         : said + ".");
        for (auto other = std::next(found); other != found_.columns.end(); ++other)
            if (other->use == Use::emg) {
                other->use = Use::not_used;
                other->reason = "the EMG is in " + found->name;
            }
    }

    InspectionOptions options_;
    std::string path_;
    TableInspection found_;
    std::vector<std::optional<ValueUnit>> units_;
    std::vector<std::size_t> used_;
    Quantity quantity_ = Quantity::force;
    bool guesses_counts_ = false;
    bool assumed_fsr_ = false;
};

}  // namespace

TableInspection inspect(Table table, const std::string& path, const InspectionOptions& options) {
    return Inspector(std::move(table), path, options).result();
}

Result<TableInspection> inspect_table(const std::filesystem::path& file, const InspectionOptions& options) {
    auto read =
        read_table(file, options.table,
                   {.most_values = TableInspection::most_values, .cuts = true, .progress = options.progress});
    if (const auto* error = std::get_if<TableError>(&read))
        return Error{Error::Kind::malformed, error->message()};
    TableInspection found = inspect(std::move(std::get<Table>(read)), file.filename().string(), options);
    if (found.scene) found.scene->folder = file.parent_path();
    return found;
}

Scene scene_for(const std::filesystem::path& file, const InspectionOptions& options) {
    auto found = inspect_table(file, options);
    if (!found) throw SceneError({found.error().text});
    if (!found.value().scene) throw SceneError({file.string() + ": " + found.value().why_no_scene});
    return std::move(*found.value().scene);
}

}  // namespace afferent
