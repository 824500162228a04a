#include "afferent/nodes/sample_source.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

#include "afferent/io/files/hdf5_process.hpp"
#include "afferent/io/files/input_file.hpp"
#include "afferent/io/files/sibling_program.hpp"
#include "afferent/nodes/image_on_skin.hpp"
#include "afferent/nodes/table_gap.hpp"
#include "afferent/runtime/piecewise_linear.hpp"

namespace afferent {
namespace {

constexpr std::size_t read_at_once = 1 << 16;

std::string joined(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

// Other units of force, and how much of a newton each is.
constexpr std::pair<std::string_view, const char*> other_units[]{
    {"_mn", "0.001"},      {"_kn", "1000"},       {"_g", "0.00980665"},
    {"_kg", "9.80665"},    {"_gf", "0.00980665"}, {"_kgf", "9.80665"},
    {"_lbf", "4.4482216"}, {"_lb", "4.4482216"},  {"_oz", "0.27801385"}};

// What to do about a column that is in neither newtons nor counts.
std::string advice(const std::string& column) {
    std::string lower = column;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const auto& [ending, factor] : other_units)
        if (lower.ends_with(ending))
            return "multiply \"" + column + "\" by " + factor + " and call it \"" +
                   column.substr(0, column.size() - ending.size()) + "_n\"";
    return "rename \"" + column +
           "\" if it is in one of these, or let the scene's table name the columns to read";
}

Error malformed(std::string text) { return {Error::Kind::malformed, std::move(text)}; }

TimePoint rounded_time(double time_s) { return scene_start + from_seconds(time_s); }

}  // namespace

void tell_shares(const Plan& plan, ControllerStep& step) {
    if (!step.true_force_n) return;
    for (std::size_t i = 0; i < step.parts.size(); ++i)
        step.parts[i].true_force_n = plan.controller->parts[i].decoded.share * *step.true_force_n;
}

void SampleSource::tell_true_forces(ControllerStep& step) const { tell_shares(plan_, step); }

SampleSource::SampleSource(const Plan& plan) : plan_(plan), index_(plan.patches.size()) {
    sensors_.reserve(plan.patches.size());
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        if (!plan.patches[i].owns_elements) continue;
        index_[i] = sensors_.size();
        owners_.push_back(i);
        sensors_.emplace_back(plan.patches[i], plan.scene.seed);
    }
}

std::uint64_t SampleSource::samples() const noexcept {
    std::uint64_t sum = 0;
    for (const PatchSensors& sensors : sensors_) sum += sensors.samples();
    return sum;
}

std::uint64_t SampleSource::clipped() const noexcept {
    std::uint64_t sum = 0;
    for (const PatchSensors& sensors : sensors_) sum += sensors.clipped();
    return sum;
}

ClockedSource::ClockedSource(const Plan& plan)
    : SampleSource(plan), queue_(plan.patches.size()), taken_(plan.patches.size(), 0) {
    for (const std::size_t patch : owners())
        queue_.schedule({scene_start, Kind::scan, static_cast<Address>(patch)});
}

std::optional<double> ClockedSource::true_force_n(TimePoint time) const {
    const auto* profile = std::get_if<scene::Profile>(&plan().scene.source);
    if (!profile) return std::nullopt;
    return interpolate(profile->point, &scene::ProfilePoint::time_s, &scene::ProfilePoint::force_n,
                       seconds(time));
}

std::optional<Scan> ClockedSource::take(double hand_force_n) {
    const Due due = queue_.pop();
    const PatchPlan& patch = plan().patches[due.address];
    queue_.schedule({sample_time(++taken_[due.address], patch.sensor.rate_hz), Kind::scan, due.address});
    const double grip_n = true_force_n(due.time).value_or(hand_force_n);
    PatchSensors& sensors = this->sensors(due.address);
    const std::uint64_t clipped = sensors.clipped();
    const auto forces_n = sensors.feel(grip_n);
    if (patch.sensor.out_of_range == scene::OutOfRange::refuse && sensors.clipped() != clipped) {
        refused_ = {due, grip_n};
        return std::nullopt;
    }
    return Scan{due.time, patch.first_element, forces_n};
}

Error ClockedSource::refusal() const {
    return malformed("patch \"" + plan().patches[refused_.due.address].name +
                     "\": a force beyond full scale at " + std::to_string(seconds(refused_.due.time)) +
                     " s, under a grip force of " + std::to_string(refused_.grip_n) +
                     " N; sensor.out_of_range is REFUSE");
}

TableSource::TableSource(const Plan& plan, scene::Table table, Read read)
    : SampleSource(plan),
      table_(std::move(table)),
      reader_(table_.path, table_.column),
      read_(std::move(read)),
      buffer_(read_ ? read_at_once : 0),
      queue_(plan.patches.size()),
      taken_(plan.patches.size(), 0) {}

Result<std::unique_ptr<TableSource>> TableSource::open(const Plan& plan, const scene::Table& table) {
    scene::Table resolved = table;
    resolved.path = plan.scene.resolve(table.path).string();
    if (scene::is_hdf5(table)) {
        AFFERENT_TRY(
            scans,
            Hdf5Process(sibling_program("afferent-hdf5")).read_scans(resolved.path, table.column.front()));
        return of_scans(plan, std::move(resolved), std::move(scans));
    }
    AFFERENT_TRY(opened, open_input(resolved.path));
    const std::shared_ptr<std::FILE> file(std::move(opened));
    auto source = std::make_unique<TableSource>(plan, std::move(resolved), [file](std::span<char> buffer) {
        return std::fread(buffer.data(), 1, buffer.size(), file.get());
    });
    source->read_ahead();
    if (source->error_) return *source->error_;
    return source;
}

Result<std::unique_ptr<TableSource>> TableSource::of_scans(const Plan& plan, scene::Table table,
                                                           ScanSet scans) {
    auto source = std::make_unique<TableSource>(plan, std::move(table));
    source->scans_ = std::move(scans);
    AFFERENT_TRY(source->understand_scans());
    return source;
}

Result<void> TableSource::understand_scans() {
    const std::string& name = table_.column.front();
    const bool newtons = name.ends_with("_n");
    const std::string about = table_.path + ": " + name + " ";
    if (!newtons && (!name.ends_with("_counts") || scans_->is_image()))
        return malformed(about + (scans_->is_image() ? "must end in _n: images are of newtons"
                                                     : "must end in _n (newtons) or _counts"));
    columns_ = newtons ? Columns::elements_n : Columns::elements_counts;
    if (!scans_->is_image()) {
        if (scans_->columns() == plan().elements) return success();
        if (scans_->columns() == 1 && newtons) {
            columns_ = Columns::grip_n;
            return success();
        }
        return malformed(about + "has " + std::to_string(scans_->columns()) +
                         " values in a scan, and the scene has " + std::to_string(plan().elements) +
                         " elements");
    }
    for (const std::size_t owner : owners())
        if (!plan().patches[owner].grid)
            return malformed(about + "is of images, and patch \"" + plan().patches[owner].name +
                             "\" has no outline to lay them over");
    image_ = image_on_skin(plan(), scans_->rows(), scans_->columns());
    pixels_.resize(scans_->rows() * scans_->columns());
    return success();
}

void TableSource::read_scan() {
    Row row{rounded_time(scans_->time_s(next_scan_)), next_scan_ + 1,
            std::vector<double>(image_ ? plan().elements : scans_->columns()), 0};
    scans_->copy(next_scan_, image_ ? pixels_ : row.values);
    const std::vector<double>& read = image_ ? pixels_ : row.values;
    if (!std::all_of(read.begin(), read.end(), [](double value) { return std::isfinite(value); })) {
        error_ = malformed(table_.path + ":" + std::to_string(row.line) +
                           ": the scan has a value that is no number");
        ended_ = true;
        return;
    }
    if (image_)
        for (std::uint32_t i = 0; i < row.values.size(); ++i) row.values[i] = image_->sum(i, pixels_);
    rows_.push_back(std::move(row));
    ended_ = ++next_scan_ == scans_->scans();
}

Result<void> TableSource::feed(std::string_view bytes) {
    const auto failed = reader_.feed(bytes, [&](const TableRow& row) {
        rows_.push_back({row.time, row.line, {row.values.begin(), row.values.end()}, 0});
    });
    if (failed) return malformed(failed->message());
    return success();
}

Result<void> TableSource::finish() {
    ended_ = true;
    if (const auto failed = reader_.finish()) return malformed(failed->message());
    return success();
}

void TableSource::read_once() {
    if (scans_) return read_scan();
    const std::size_t count = read_(buffer_);
    const Result<void> result = count > 0 ? feed({buffer_.data(), count}) : finish();
    if (!result) {
        error_ = result.error();
        ended_ = true;
    }
}

Result<void> TableSource::read_all() {
    while (read_ && !ended_) read_once();
    read_ahead();
    return error_ ? Result<void>(*error_) : success();
}

void TableSource::read_ahead() {
    while (!is_fed() && starving()) read_once();
    if (columns_ == Columns::unknown && !rows_.empty()) {
        if (const Result<void> understood = understand_columns(); !understood) {
            error_ = understood.error();
            rows_.clear();
            ended_ = true;
        }
    }
}

Result<void> TableSource::understand_columns() {
    const auto& names = reader_.columns();
    const auto all_end_in = [&](std::string_view suffix) {
        return std::all_of(names.begin(), names.end(),
                           [&](const std::string& name) { return name.ends_with(suffix); });
    };
    const bool newtons = all_end_in("_n");
    if (!newtons && !all_end_in("_counts")) {
        const auto stranger = std::find_if(names.begin(), names.end(), [](const std::string& name) {
            return !name.ends_with("_n") && !name.ends_with("_counts");
        });
        return malformed(table_.path +
                         ":1: every column must end in _n (newtons), or every one in _counts (of the "
                         "converter); they are " +
                         joined(names) + (stranger == names.end() ? "" : ": " + advice(*stranger)));
    }
    // A single column in newtons is the grip force, even if there is only one element.
    if (names.size() == 1 && newtons)
        columns_ = Columns::grip_n;
    else if (names.size() == plan().elements)
        columns_ = newtons ? Columns::elements_n : Columns::elements_counts;
    if (columns_ == Columns::unknown)
        return malformed(
            table_.path + ":1: the scene has " + std::to_string(plan().elements) +
            " elements: it takes one column of grip force in newtons, or one for each element; there are " +
            std::to_string(names.size()) + " (" + joined(names) + ")");
    return success();
}

std::optional<Due> TableSource::next() {
    read_ahead();
    if (queue_.empty()) begin_row();
    return queue_.empty() ? std::nullopt : std::optional(queue_.next());
}

void TableSource::begin_row() {
    if (rows_.empty()) return;
    checked_ = false;
    rows_.front().grip_force_n = grip_force_n(rows_.front().values);
    for (const std::size_t owner : owners()) {
        taken_[owner] = 1;
        const TimePoint first = before_
                                    ? TableGap{before_->time, rows_.front().time}.step(1, steps_to_row(owner))
                                    : rows_.front().time;
        queue_.schedule({first, Kind::scan, static_cast<Address>(owner)});
    }
}

std::int64_t TableSource::steps_to_row(std::size_t patch) const noexcept {
    if (!before_) return 1;
    return TableGap{before_->time, rows_.front().time}.steps(plan().patches[patch].scan_interval,
                                                             table_.between);
}

std::span<const double> TableSource::values(TimePoint time) {
    const Row& row = rows_.front();
    if (!before_ || time == row.time) return row.values;
    const double fraction = TableGap{before_->time, row.time}.fraction(time);
    values_.resize(row.values.size());
    for (std::size_t i = 0; i < values_.size(); ++i)
        values_[i] = std::lerp(before_->values[i], row.values[i], fraction);
    return values_;
}

double TableSource::between(TimePoint time, double before, double after) const {
    if (table_.between == scene::Between::hold || queue_.empty()) return before;
    const TableGap gap{before_->time, rows_.front().time};
    return time >= gap.next ? after : std::lerp(before, after, gap.fraction(time));
}

std::optional<double> TableSource::true_force_n(TimePoint time) const {
    if (!before_) return std::nullopt;
    return between(time, before_->grip_force_n, rows_.empty() ? 0 : rows_.front().grip_force_n);
}

void TableSource::tell_true_forces(ControllerStep& step) const {
    if (columns_ == Columns::grip_n) return SampleSource::tell_true_forces(step);
    if (!before_) return;
    const auto force_n = [&](const Row& row, const PartPlan& part) {
        double sum = 0;
        for (Address i = part.first_element; i < part.first_element + part.elements; ++i)
            sum +=
                columns_ == Columns::elements_n ? row.values[i] : sensors(part.patch).force_n(row.values[i]);
        return sum;
    };
    for (std::size_t i = 0; i < step.parts.size(); ++i) {
        const PartPlan& part = plan().controller->parts[i];
        step.parts[i].true_force_n =
            between(step.time, force_n(*before_, part), queue_.empty() ? 0 : force_n(rows_.front(), part));
    }
}

double TableSource::grip_force_n(const std::vector<double>& values) const {
    double sum = 0;
    std::size_t column = 0;
    if (columns_ != Columns::elements_counts) {
        for (const double force_n : values) sum += force_n;
        return sum;
    }
    for (const std::size_t owner : owners())
        for (std::uint32_t i = 0; i < plan().patches[owner].elements(); ++i)
            sum += sensors(owner).force_n(values[column++]);
    return sum;
}

std::optional<TableSource::Refused> TableSource::out_of_range(const Row& row) const {
    if (table_.out_of_range != scene::OutOfRange::refuse) return std::nullopt;
    std::size_t column = 0;
    for (const std::size_t owner : owners()) {
        const PatchPlan& patch = plan().patches[owner];
        const Sensor sensor(patch.sensor);
        for (std::uint32_t i = 0; i < patch.elements(); ++i) {
            const double value =
                columns_ == Columns::grip_n ? row.values[0] * patch.share[i] : row.values[column++];
            const bool within = columns_ == Columns::elements_counts
                                    ? value >= 0 && value <= sensor.highest_count()
                                    : sensor.within_range(value);
            if (!within) return Refused{&patch, value};
        }
    }
    return std::nullopt;
}

Error TableSource::refusal() const {
    const Row& row = rows_.front();
    const auto [patch, value] = out_of_range(row).value();
    return malformed(table_.path + ":" + std::to_string(row.line) + ": " +
                     (value < 0 ? "negative" : "beyond the full scale of patch \"" + patch->name + "\"") +
                     ", and out_of_range is REFUSE: " + std::to_string(value) +
                     (columns_ != Columns::elements_counts && value > 2 * patch->sensor.full_scale_n
                          ? " N. Counts stand in columns that end in _counts"
                          : ""));
}

std::optional<Scan> TableSource::take(double) {
    if (!checked_ && out_of_range(rows_.front())) return std::nullopt;
    checked_ = true;
    const Due due = queue_.pop();
    const std::size_t owner = due.address;
    const PatchPlan& patch = plan().patches[owner];
    // The columns of a patch follow those of the patches before it.
    const std::span<const double> values = this->values(due.time);
    PatchSensors& sensors = this->sensors(owner);
    const Scan scan{due.time, patch.first_element,
                    columns_ == Columns::grip_n ? sensors.feel(values[0])
                    : columns_ == Columns::elements_n
                        ? sensors.take_newtons(values.subspan(patch.first_element, patch.elements()))
                        : sensors.take_counts(values.subspan(patch.first_element, patch.elements()))};
    const std::int64_t steps = steps_to_row(owner);
    if (taken_[owner] < steps) {
        const TableGap gap{before_->time, rows_.front().time};
        queue_.schedule({gap.step(++taken_[owner], steps), Kind::scan, due.address});
    }
    if (queue_.empty()) {
        before_ = std::move(rows_.front());
        rows_.pop_front();
    }
    return scan;
}

}  // namespace afferent
