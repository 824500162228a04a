#include "afferent/nodes/coprocessor_end.hpp"

#include <algorithm>
#include <cstdio>

#include "afferent/io/wire/raw_samples.hpp"
#include "afferent/nodes/stimulus_source.hpp"

namespace afferent {

Result<std::unique_ptr<CoprocessorEnd>> CoprocessorEnd::open(const Plan& plan,
                                                             TableSource::Read standard_input,
                                                             EventExchange* exchange,
                                                             std::optional<ScanSet> forces) {
    std::unique_ptr<CoprocessorEnd> link_end(new CoprocessorEnd(plan, exchange));
    const auto keep = [&]<class Source>(std::unique_ptr<Source> source) {
        if constexpr (std::is_same_v<Source, TableSource>) link_end->table_ = source.get();
        if constexpr (std::is_same_v<Source, PushedSource>) link_end->pushed_ = source.get();
        link_end->source_ = std::move(source);
        return success();
    };
    AFFERENT_TRY(std::visit(
        Overloaded{
            [](const scene::SimulatedHand&) -> Result<void> { return success(); },
            [](const scene::LinkSource&) -> Result<void> { return success(); },
            [](const scene::HandSensors&) -> Result<void> { return success(); },
            [&](const scene::Chip& chip) -> Result<void> {
                link_end->chip_.emplace(plan, chip.compare ? &link_end->coprocessor_ : nullptr);
                return success();
            },
            [&](const scene::Profile&) -> Result<void> {
                return keep(std::make_unique<ClockedSource>(plan));
            },
            [&](const scene::Touch&) -> Result<void> { return keep(std::make_unique<StimulusSource>(plan)); },
            [&](const scene::Pushed&) -> Result<void> { return keep(std::make_unique<PushedSource>(plan)); },
            [&](const scene::Table& file) -> Result<void> {
                AFFERENT_TRY(table, forces ? TableSource::of_scans(plan, file, std::move(*forces))
                                           : TableSource::open(plan, file));
                return keep(std::move(table));
            },
            [&](const scene::StandardInput& input) -> Result<void> {
                return keep(std::make_unique<TableSource>(plan,
                                                          scene::Table{.path = "standard input",
                                                                       .column = input.column,
                                                                       .out_of_range = input.out_of_range,
                                                                       .between = scene::Between::hold,
                                                                       .time_column = input.time_column,
                                                                       .time_unit = input.time_unit,
                                                                       .unit = input.unit},
                                                          std::move(standard_input)));
            }},
        plan.scene.source));
    return link_end;
}

CoprocessorEnd::CoprocessorEnd(const Plan& plan, EventExchange* exchange)
    : span_(plan.timing.span),
      adc_bits_(0),
      coprocessor_(plan),
      exchange_(exchange),
      deadline_(scene_start + span_),
      raw_scans_(plan.elements + 1) {
    for (const PatchPlan& patch : plan.patches) adc_bits_ = std::max(adc_bits_, patch.sensor.adc_bits);
    if (plan.packets) packetizer_.emplace(*plan.packets);
    if (plan.skip_scans_after) overdue_.emplace(plan.elements, *plan.skip_scans_after);
    if (!plan.bus) return;
    bus_.emplace(*plan.bus);
    // A span has no more events than cycles; room for more than a few events of each neuron is made when it
    // is needed.
    const auto cycles = static_cast<std::size_t>(span_ / plan.bus->cycle) + 2;
    passed_.reserve(std::min<std::size_t>(cycles, 1024 + 4 * std::size_t{plan.addresses}));
}

void CoprocessorEnd::begin_at(TimePoint time) {
    closed_ = scene_start + (time - scene_start) / span_ * span_;
    deadline_ = closed_ + span_;
    if (chip_) chip_->begin_at(closed_);
    if (packetizer_) packetizer_->begin_at(closed_);
}

Due CoprocessorEnd::next() {
    const Due deadline{deadline_, Kind::packet_deadline, 0};
    if (source_)
        if (const auto scan = source_->next(); scan && *scan < deadline) return *scan;
    return deadline;
}

Result<void> CoprocessorEnd::do_next(const Observer& observer, Duration behind) {
    const Due due = next();
    if (due.kind == Kind::scan) {
        const std::optional<Scan> scan = source_->take(0);
        if (!scan) return source_->refusal();
        push(*scan, observer, behind);
        return success();
    }
    if (table_ && table_->error()) return *table_->error();
    // No scan has come since that could have brought the neurons up to date.
    if (overdue_ && !overdue_->empty() && !overdue_->overdue(behind))
        give_overdue(std::max(overdue_->time(), closed_), observer);
    AFFERENT_TRY(close_span(due.time, observer));
    if (packetizer_) packetizer_->close(due.time, observer.packet);
    deadline_ += span_;
    return success();
}

void CoprocessorEnd::push(const Scan& scan, const Observer& observer, Duration behind) {
    count_raw(scan);
    const bool overdue = overdue_ && overdue_->overdue(behind);
    if (!overdue && (!overdue_ || overdue_->empty())) return give(scan, observer);
    overdue_->hold(scan);
    if (!overdue) give_overdue(scan.time, observer);
}

void CoprocessorEnd::give(const Scan& scan, const Observer& observer) {
    observer.scan(scan);
    coprocessor_.push(scan);
    if (exchange_) exchange_->push(scan);
}

void CoprocessorEnd::give_overdue(TimePoint time, const Observer& observer) {
    overdue_->release(time, [&](const Scan& scan) { give(scan, observer); });
}

// Closes the span of everything before `end`: an event at `end` belongs to the next.
Result<void> CoprocessorEnd::close_span(TimePoint end, const Observer& observer) {
    AFFERENT_TRY(events, events_until(end - Duration(1)));
    events_ += events.size();
    if (bus_) {
        passed_.clear();
        bus_->pass(events, end, passed_);
        events = passed_;
    }
    observer.events(events);
    if (packetizer_)
        packetizer_->push(events);
    else
        observer.span({.gap = std::nullopt, .known = {closed_, end}, .events = events, .more = false});
    closed_ = end;
    return success();
}

Result<std::span<const Event>> CoprocessorEnd::events_until(TimePoint until) {
    if (chip_) return chip_->take(until);
    if (!exchange_) return coprocessor_.advance(until);
    exchange_->begin(until);
    return exchange_->exchange(until, coprocessor_.advance(until));
}

void CoprocessorEnd::finish(TimePoint end, const Observer& observer) {
    if (end > closed_ && !close_span(end, observer)) return;
    if (packetizer_) packetizer_->finish(end, observer.packet);
}

void CoprocessorEnd::count_raw(const Scan& scan) {
    samples_ += scan.forces_n.size();
    // Another patch at the same time goes into the same frame.
    if (scan.time != raw_time_) {
        ++raw_scans_[raw_samples_];
        raw_samples_ = 0;
    }
    raw_time_ = scan.time;
    raw_samples_ = std::min(raw_samples_ + scan.forces_n.size(), raw_scans_.size() - 1);
}

std::uint64_t CoprocessorEnd::raw_sample_bytes() const {
    if (!packetizer_) return 0;
    const auto bytes = [&](std::size_t samples) { return afferent::raw_sample_bytes(samples, adc_bits_); };
    std::uint64_t sum = raw_samples_ > 0 ? bytes(raw_samples_) : 0;
    for (std::size_t samples = 1; samples < raw_scans_.size(); ++samples)
        if (raw_scans_[samples] > 0) sum += raw_scans_[samples] * bytes(samples);
    return sum;
}

}  // namespace afferent
