#include "afferent/nodes/sample_source.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/nodes/image_on_skin.hpp"
#include "afferent/nodes/table_columns.hpp"
#include "afferent/nodes/table_gap.hpp"
#include "afferent/nodes/table_notes.hpp"
#include "afferent/runtime/piecewise_linear.hpp"
#include "afferent/scene/scene_table.hpp"

namespace afferent {
namespace {

constexpr std::size_t read_at_once = 1 << 16;

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

std::string SampleSource::said_of_clipped() const {
    std::uint64_t negative = 0;
    std::uint64_t positive = 0;
    for (const PatchSensors& sensors : sensors_) {
        negative += sensors.negative();
        positive += sensors.positive();
    }
    if (2 * clipped() <= negative + positive) return "";
    const std::string most = " of " + std::to_string(samples()) + " samples are ";
    if (negative > positive)
        return std::to_string(negative) + most +
               "below 0, and read as 0: is the sign reversed, or the zero wrong?";
    return std::to_string(clipped() - negative) + most +
           "beyond full scale, and read as that: is sensor { full_scale_n } too low, or the unit another?";
}

ClockedSource::ClockedSource(const Plan& plan)
    : SampleSource(plan), queue_(plan.patches.size()), taken_(plan.patches.size(), 0) {
    for (const std::size_t patch : owners())
        queue_.schedule({scene_start, Kind::scan, static_cast<Address>(patch)});
}

std::optional<Scan> ClockedSource::take(double hand_force_n) {
    const Due due = queue_.pop();
    const PatchPlan& patch = plan().patches[due.address];
    queue_.schedule({sample_time(++taken_[due.address], patch.sensor.rate_hz), Kind::scan, due.address});
    PatchSensors& sensors = this->sensors(due.address);
    const double grip_n = sensors.arriving_n(true_force_n(due.time).value_or(hand_force_n));
    const std::uint64_t clipped = sensors.clipped();
    const auto forces_n = sensors.feel(grip_n);
    if (patch.sensor.out_of_range == scene::OutOfRange::refuse && sensors.clipped() != clipped) {
        refused_ = {due, grip_n};
        return std::nullopt;
    }
    return Scan{due.time, patch.first_element + patch.sampled.begin, forces_n};
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
      reader_(table_.path, table_options(table_)),
      read_(std::move(read)),
      buffer_(read_ ? read_at_once : 0),
      queue_(plan.patches.size()),
      taken_(plan.patches.size(), 0) {}

Result<std::unique_ptr<TableSource>> TableSource::open(const Plan& plan, const scene::Table& table) {
    scene::Table resolved = table;
    resolved.path = plan.scene.resolve(table.path).string();
    auto opened = TableInput::open(resolved.path, table_options(table));
    if (!opened) return opened.error();
    if (opened.value().scans) return of_scans(plan, std::move(resolved), std::move(*opened.value().scans));
    auto source = std::make_unique<TableSource>(plan, std::move(resolved), Read());
    source->reader_ = TableReader(source->table_.path, opened.value().options());
    source->file_.emplace(std::move(opened.value()));
    source->buffer_.resize(read_at_once);
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
    if (failed) return malformed((file_ ? file_->place(*failed) : *failed).message());
    return success();
}

Result<void> TableSource::finish() {
    ended_ = true;
    const auto failed = reader_.finish([&](const TableRow& row) {
        rows_.push_back({row.time, row.line, {row.values.begin(), row.values.end()}, 0});
    });
    if (failed) return malformed((file_ ? file_->place(*failed) : *failed).message());
    return success();
}

Result<std::size_t> TableSource::fill_buffer() {
    if (file_) return file_->read(buffer_);
    return read_(buffer_);
}

void TableSource::read_once() {
    if (scans_) return read_scan();
    const auto count = fill_buffer();
    const Result<void> result = !count               ? Result<void>(count.error())
                                : count.value() == 0 ? finish()
                                                     : feed({buffer_.data(), count.value()});
    if (!result) {
        error_ = result.error();
        ended_ = true;
    }
}

Result<void> TableSource::read_all() {
    // The row itself takes some memory beside its values.
    constexpr std::size_t most_bytes = std::size_t{256} << 20U;
    const auto bytes = [this] {
        return rows_.empty()
                   ? 0
                   : rows_.size() * (sizeof(Row) + 32 + rows_.front().values.size() * sizeof(double));
    };
    while (!is_fed() && !ended_ && bytes() < most_bytes) read_once();
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
    auto understood = table_columns(names, table_.unit);
    if (!understood) return malformed(table_.path + ":1: " + understood.error().text);
    TableColumns& of = understood.value();
    const bool newtons = of.quantity == Quantity::force;
    volts_to_counts(of, plan());
    // A single column in newtons is the grip force, even if there is only one element.
    if (names.size() == 1 && newtons)
        columns_ = Columns::grip_n;
    else if (names.size() == plan().elements)
        columns_ = newtons ? Columns::elements_n : Columns::elements_counts;
    if (columns_ == Columns::unknown)
        return malformed(
            table_.path + ":1: the scene has " + std::to_string(plan().elements) +
            " elements: it takes one column of grip force in newtons, or one for each element; there are " +
            std::to_string(names.size()) + "; name those that are elements (--columns)");
    if (std::ranges::any_of(of.factors, [](double factor) { return factor != 1; }))
        factors_ = std::move(of.factors);
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
    for (std::size_t i = 0; i < factors_.size(); ++i) rows_.front().values[i] *= factors_[i];
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

TableFormat TableSource::format() const {
    TableFormat format = reader_.format();
    if (file_) file_->complete(format);
    return format;
}

std::optional<TimePoint> TableSource::end() const {
    if (!ended_ || error_ || !rows_.empty() || !before_) return std::nullopt;
    return before_->time;
}

std::vector<std::string> TableSource::said() const {
    std::vector<std::string> said;
    const TableFormat format = this->format();
    if (format.begin != Duration::zero())
        said.push_back("Forces: the table's time " + in_seconds(format.begin) + format.said_of_epoch() +
                       " is the scene's 0");
    if (!format.time_column.empty() && !format.unit_is_said && !scans_)
        said.push_back("Forces: nothing says what \"" + format.time_column +
                       "\" is in, and it is taken for " + unit_name(format.time_unit));
    if (format.missing.rows != 0) said.push_back("Forces: " + format.said_of_missing());
    if (format.left_out_line != 0) said.push_back("Forces: " + format.said_of_left_out_line());
    if (const auto last = end(); last && *last + table_end_tolerance < plan().end())
        said.push_back("Forces: the table ends at " + in_seconds(*last - scene_start) + ", the scene at " +
                       in_seconds(plan().end() - scene_start) + "; the last forces are held until then");
    return said;
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
