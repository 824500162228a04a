// The coprocessor's side of a scene: samples in, packets out.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "afferent/io/wire/event_bus.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/scene/coprocessor.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Steps through its own events: scans of the samples that are on this side, and the deadlines of packets.
// Scans from the other side are pushed.
class CoprocessorSide {
  public:
    struct Output {
        // As they are computed, sorted; where there is a bus, as they leave it.
        std::function<void(std::span<const Event>)> events = [](auto) {};
        // The samples that the neurons are given.
        std::function<void(const Scan&)> scan = [](const auto&) {};
        // Where the link carries packets: each as it closes.
        std::function<void(const proto::Envelope&)> packet = [](const auto&) {};
        // Where it does not: the events of each span between two deadlines.
        std::function<void(const Reception&)> hand_over = [](const auto&) {};
    };

    // Opens the table that is on this side, if there is one. Where samples come from standard input,
    // `standard_input` reads it; without, its bytes are fed to table().
    static Result<std::unique_ptr<CoprocessorSide>> open(const Scene& scene,
                                                         TableSource::Read standard_input = {});

    // Begins in the middle of the scene, with neurons at rest until then. Before the first step.
    void begin_at(TimePoint time);

    // What is due next; packets close before scans of the same time.
    Due next();
    // Does that. Throws SpikeStormError.
    Result<void> do_next(const Output& output);
    void push(const Scan& scan, const Output& output);
    // The end of the scene: closes what is open.
    void finish(TimePoint end, const Output& output);

    // Of the next packet.
    TimePoint deadline() const noexcept { return deadline_; }

    // Samples that come in from outside, where this is their source.
    TableSource* table() const noexcept { return table_; }
    const SampleSource* source() const noexcept { return source_.get(); }
    const Coprocessor& coprocessor() const noexcept { return coprocessor_; }
    // Null where the link carries no packets.
    const Packetizer* packetizer() const noexcept { return packetizer_ ? &*packetizer_ : nullptr; }
    Packetizer* packetizer() noexcept { return packetizer_ ? &*packetizer_ : nullptr; }
    // That neurons have fired.
    std::uint64_t events() const noexcept { return events_; }
    // Null where the scene has none.
    const EventBus* bus() const noexcept { return bus_ ? &*bus_ : nullptr; }
    // What all samples so far would have taken in the same scans, packed at the converter's resolution: one
    // scan for each sampling time.
    std::uint64_t raw_sample_bytes() const;
    std::uint64_t samples() const noexcept { return samples_; }

  private:
    explicit CoprocessorSide(const Scene& scene);
    void close_span(TimePoint end, const Output& output);
    void count_raw(const Scan& scan);

    Duration span_;
    unsigned adc_bits_;
    Coprocessor coprocessor_;
    std::unique_ptr<SampleSource> source_;
    TableSource* table_ = nullptr;  // source_, where it is a table
    std::optional<EventBus> bus_;
    std::vector<Event> passed_;  // out of the bus, in this span
    std::optional<Packetizer> packetizer_;
    TimePoint deadline_;
    TimePoint closed_ = scene_start;
    std::uint64_t events_ = 0;

    std::uint64_t samples_ = 0;
    TimePoint raw_time_ = TimePoint::min();
    std::size_t raw_samples_ = 0;           // at that time
    std::vector<std::uint64_t> raw_scans_;  // how many scans of so many samples there would have been
};

}  // namespace afferent
