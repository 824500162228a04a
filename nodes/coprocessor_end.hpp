// The coprocessor's end of a scene: samples in, packets out.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/io/wire/event_bus.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/chip_reader.hpp"
#include "afferent/nodes/event_exchange.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/nodes/overdue_scans.hpp"
#include "afferent/nodes/pushed_source.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Does one thing after another: takes the scans of samples that are on this end, and closes packets at their
// deadlines. Scans from the other end are pushed.
class CoprocessorEnd {
  public:
    // Opens the table that is on this end, if there is one. Where samples come from standard input,
    // `standard_input` reads it; without that function, its bytes are to be fed to table(). `exchange`
    // outlives the end; null: all neurons are in this process. `forces` are read in place of the table.
    static Result<std::unique_ptr<CoprocessorEnd>> open(const Plan& plan,
                                                        TableSource::Read standard_input = {},
                                                        EventExchange* exchange = nullptr,
                                                        std::optional<ScanSet> forces = {});

    // Begins in the middle of the scene, with neurons at rest. To be called before anything is done.
    void begin_at(TimePoint time);

    // The next thing due; packets close before scans of the same time.
    Due next();
    // Does what is due next, `behind` after it was due by the clock: the scene may say that scans are skipped
    // then. Throws SpikeStormError.
    Result<void> do_next(const Observer& observer, Duration behind = {});
    void push(const Scan& scan, const Observer& observer, Duration behind = {});
    // The end of the scene: closes the packet that is open. Where the exchange fails, it stays as it is.
    void finish(TimePoint end, const Observer& observer);

    // Null where the neurons are emulated.
    ChipReader* chip() noexcept { return chip_ ? &*chip_ : nullptr; }
    const ChipReader* chip() const noexcept { return chip_ ? &*chip_ : nullptr; }
    // No scan that is still to come is known yet.
    bool awaits_samples() { return !source_ || !source_->next(); }
    // When the next packet closes.
    TimePoint deadline() const noexcept { return deadline_; }

    // The source, where it is a table; null otherwise.
    TableSource* table() const noexcept { return table_; }
    // The source, where it is pushed into; null otherwise.
    PushedSource* pushed() const noexcept { return pushed_; }
    const SampleSource* source() const noexcept { return source_.get(); }
    const Coprocessor& coprocessor() const noexcept { return coprocessor_; }
    // Null where the link carries no packets.
    const Packetizer* packetizer() const noexcept { return packetizer_ ? &*packetizer_ : nullptr; }
    Packetizer* packetizer() noexcept { return packetizer_ ? &*packetizer_ : nullptr; }
    // Null where the plan has no skipping of scans.
    const OverdueScans* overdue() const noexcept { return overdue_ ? &*overdue_ : nullptr; }
    // How many events the neurons have fired.
    std::uint64_t events() const noexcept { return events_; }
    // Null where the scene has none.
    const EventBus* bus() const noexcept { return bus_ ? &*bus_ : nullptr; }
    // What a link would have carried if all samples so far had been sent instead: one frame for each sampling
    // time, packed at the converter's resolution.
    std::uint64_t raw_sample_bytes() const;
    std::uint64_t samples() const noexcept { return samples_; }

  private:
    CoprocessorEnd(const Plan& plan, EventExchange* exchange);
    Result<void> close_span(TimePoint end, const Observer& observer);
    Result<std::span<const Event>> events_until(TimePoint until);
    void give(const Scan& scan, const Observer& observer);
    void give_overdue(TimePoint time, const Observer& observer);
    void count_raw(const Scan& scan);

    Duration span_;
    unsigned adc_bits_;
    Coprocessor coprocessor_;
    EventExchange* exchange_;
    std::optional<ChipReader> chip_;
    std::unique_ptr<SampleSource> source_;
    TableSource* table_ = nullptr;    // source_, where it is a table
    PushedSource* pushed_ = nullptr;  // source_, where it is pushed into
    std::optional<OverdueScans> overdue_;
    std::optional<EventBus> bus_;
    std::vector<Event> passed_;  // out of the bus, in this span
    std::optional<Packetizer> packetizer_;
    TimePoint deadline_;
    TimePoint closed_ = scene_start;
    std::uint64_t events_ = 0;

    std::uint64_t samples_ = 0;
    TimePoint raw_time_ = TimePoint::min();
    std::size_t raw_samples_ = 0;           // at that time
    std::vector<std::uint64_t> raw_scans_;  // how many sampling times had 0, 1, 2 ... samples
};

}  // namespace afferent
