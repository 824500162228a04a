#include "afferent/chip/vectors.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <tuple>

#include "afferent/io/wire/cobs.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packetizer.hpp"

namespace afferent {
namespace {

using Kind = VectorRecord::Kind;

// The inverse of an odd number modulo 2^64; each step doubles the bits that are right.
std::uint64_t inverse(std::uint64_t odd) {
    std::uint64_t found = odd;
    for (int i = 0; i < 6; ++i) found *= 2 - odd * found;
    return found;
}

// One neuron through its whole time.
class Course {
  public:
    Course(const ChipNeurons& neurons, Address address, std::uint64_t seed,
           std::vector<VectorRecord>& records)
        : neuron_(neurons.neuron(address)),
          codes_(neuron_.codes()),
          address_(address),
          state_(neurons.start[address]),
          input_(neuron_.input(0)),
          random_(seed * 0x9E3779B97F4A7C15ULL + address),
          records_(records) {}

    void run(const VectorLength& length, const CountsCurve* curve) {
        busy(length.busy);
        saturate(length.busy);
        for (std::int64_t left = length.silent; left > 0; --left) {
            const FixedPointLif::State before = state_;
            tick();
            // From here on nothing changes.
            if (state_ == before) {
                tick_ += left - 1;
                break;
            }
        }
        record_state();
        busy(length.busy);
        record_state();
        if (curve) read(*curve, length.read);
    }

  private:
    void busy(std::int64_t ticks) {
        const std::int64_t gap = codes_.threshold - codes_.reset;
        for (const std::int64_t end = tick_ + ticks; tick_ < end;) {
            const auto length = std::min<std::int64_t>(end - tick_, between(1, 400));
            switch (between(0, 9)) {
                case 0:  // as much as there is, and little enough of it
                    set(chance() ? largest() : -largest() - 1);
                    run_for(std::min<std::int64_t>(length, 20));
                    break;
                case 1:  // an input that changes at each tick
                    for (std::int64_t i = 0; i < length; ++i) {
                        set(codes_.threshold + between(-2 * gap, 6 * gap));
                        tick();
                    }
                    break;
                case 2:
                case 5:  // ties
                    for (std::int64_t i = 0; i < length; ++i) {
                        if (const auto tie = input_of_a_tie(codes_.threshold + between(-gap, 3 * gap)))
                            set(*tie);
                        tick();
                    }
                    break;
                case 3:  // an input that changes at a spike
                    set(codes_.threshold + between(1, 2 * gap));
                    for (std::int64_t i = 0; i < length; ++i)
                        if (tick()) set(codes_.threshold + between(-gap, 2 * gap));
                    break;
                case 4:  // about the least that makes it fire
                    set(codes_.threshold + between(-3, 3));
                    run_for(length);
                    break;
                case 6:  // just what makes it fire, and just not
                    for (std::int64_t i = 0; i < length; ++i) {
                        set(input_that_reaches(codes_.threshold - between(0, 1)));
                        tick();
                    }
                    break;
                default:
                    set(codes_.threshold + between(-gap, 4 * gap));
                    run_for(length);
            }
            record_state();
        }
    }

    // A reading at each tick: all that there are, if they are no more than that; otherwise where pieces begin
    // and end, and some of the rest.
    void read(const CountsCurve& curve, std::int64_t ticks) {
        std::vector<std::int64_t> readings;
        if (curve.highest_count < ticks) {
            readings.resize(std::size_t{curve.highest_count} + 1);
            std::iota(readings.begin(), readings.end(), 0);
            std::ranges::shuffle(readings, random_);
        } else {
            for (const CountsCurve::Piece& piece : curve.pieces) {
                if (piece.begin > 0) readings.push_back(piece.begin - 1);
                readings.push_back(piece.begin);
            }
        }
        for (std::size_t i = 0; i < static_cast<std::size_t>(ticks); ++i) {
            const std::int64_t counts =
                i < readings.size() ? readings[i] : between(0, std::int64_t{curve.highest_count} + 3);
            VectorRecord record{.tick = tick_ + 1, .kind = Kind::reading, .address = address_};
            record.input = counts;
            records_.push_back(record);
            set(curve.input(static_cast<std::uint32_t>(counts)));
            tick();
        }
        record_state();
    }

    // The largest input until g is as large as it can be.
    void saturate(std::int64_t ticks) {
        const std::int64_t end = tick_ + ticks;
        set(largest());
        while (tick_ < end && state_.g < codes_.g_most) tick();
        run_for(std::min<std::int64_t>(end - tick_, 20));
        record_state();
        set(neuron_.input(0));
        run_for(end - tick_);
    }

    void run_for(std::int64_t ticks) {
        for (; ticks > 0; --ticks)
            if (tick() && between(0, 9) == 0) record_state();
    }

    bool tick() {
        ++tick_;
        neuron_.tick(state_, input_);
        if (!neuron_.fires(state_)) return false;
        neuron_.fire(state_);
        records_.push_back({.tick = tick_, .kind = Kind::event, .address = address_});
        return true;
    }

    void set(std::int64_t input) {
        input_ = std::clamp(input, -largest() - 1, largest());
        VectorRecord record{.tick = tick_ + 1, .kind = Kind::input, .address = address_};
        record.input = input_;
        records_.push_back(record);
    }

    void record_state() {
        if (tick_ == recorded_) return;
        recorded_ = tick_;
        VectorRecord record{.tick = tick_, .kind = Kind::state, .address = address_};
        record.state = state_;
        records_.push_back(record);
    }

    // The input with which the next tick's u is that, or next to it.
    std::int64_t input_that_reaches(std::int64_t next_u) {
        FixedPointLif::State next = state_;
        const std::int64_t u = neuron_.shunted(next);
        return (next_u * codes_.one - u * codes_.v_decay) / (codes_.one - codes_.v_decay);
    }

    // The input next to that one with which the next tick's u is half way between two codes; none if there is
    // no such input.
    std::optional<std::int64_t> input_of_a_tie(std::int64_t near) {
        FixedPointLif::State next = state_;
        const std::int64_t u = neuron_.shunted(next);
        // u D + x c = half modulo 2^d. Where c is even, half of what is left has to be divisible, too.
        const std::uint64_t c = static_cast<std::uint64_t>(codes_.one - codes_.v_decay);
        const auto even = static_cast<std::uint32_t>(std::countr_zero(c));
        const std::uint64_t modulus = std::uint64_t{1} << codes_.decay_bits;
        const std::uint64_t missing =
            (modulus / 2 - static_cast<std::uint64_t>(u * codes_.v_decay)) & (modulus - 1);
        if (even >= codes_.decay_bits || (missing & ((std::uint64_t{1} << even) - 1)) != 0)
            return std::nullopt;
        const auto period = static_cast<std::int64_t>(modulus >> even);
        const auto x =
            static_cast<std::int64_t>(((missing >> even) * inverse(c >> even)) & (modulus - 1)) % period;
        const std::int64_t away = ((x - near) % period + period) % period;
        const std::int64_t found = near + away;
        if (found > largest() || found < -largest() - 1) return std::nullopt;
        return found;
    }

    std::int64_t largest() const { return (std::int64_t{1} << (codes_.input_bits - 1)) - 1; }
    std::int64_t between(std::int64_t low, std::int64_t high) {
        const auto width = static_cast<std::uint64_t>(high - low) + 1;
        return low + static_cast<std::int64_t>(random_() % width);
    }
    bool chance() { return between(0, 1) == 1; }

    const FixedPointLif& neuron_;
    const FixedPointLif::Codes& codes_;
    Address address_;
    FixedPointLif::State state_;
    std::int64_t input_;  // of no drive, to begin with
    std::int64_t tick_ = 0;
    std::int64_t recorded_ = 0;
    std::mt19937_64 random_;
    std::vector<VectorRecord>& records_;
};

// What the packets of those events are on a line.
std::vector<Vectors::Line> lines_of(const Vectors& vectors, const ChipNeurons& neurons,
                                    const PacketLayout& layout) {
    Packetizer packetizer(layout);
    packetizer.announce();
    FrameWriter writer;
    std::vector<Vectors::Line> lines;
    const std::int64_t span = layout.span.count() / neurons.tick_ns;
    const auto at = [&](std::int64_t tick) { return scene_start + Duration(tick * neurons.tick_ns); };
    auto record = vectors.records.begin();
    for (std::int64_t end = span; end <= vectors.ticks + 1; end += span) {
        for (; record != vectors.records.end() && record->tick < end; ++record)
            if (record->kind == Kind::event) {
                const Event event{at(record->tick), record->address};
                packetizer.push({&event, 1});
            }
        Vectors::Line line{.tick = std::max<std::int64_t>(end - 1, 1), .bytes = {}};
        packetizer.close(at(end), [&](const proto::Envelope& packet) {
            append_cobs(writer.datagram(packet), line.bytes);
        });
        if (line.bytes.empty()) continue;
        // Where spans are single ticks, the first has none, and ends with the second.
        if (!lines.empty() && lines.back().tick == line.tick)
            lines.back().bytes.insert(lines.back().bytes.end(), line.bytes.begin(), line.bytes.end());
        else
            lines.push_back(std::move(line));
    }
    return lines;
}

void write(const Vectors::Line& line, std::ostream& out) {
    constexpr const char* digits = "0123456789abcdef";
    std::string text;
    for (const std::byte byte : line.bytes) {
        text += digits[std::to_integer<unsigned>(byte) >> 4];
        text += digits[std::to_integer<unsigned>(byte) & 15];
    }
    out << "f " << line.tick << ' ' << line.bytes.size() << ' ' << text << '\n';
}

}  // namespace

VectorLength VectorLength::full(const ChipNeurons& neurons) noexcept {
    const std::int64_t hour = 3'600'000'000'000 / neurons.tick_ns;
    return {.busy = std::clamp<std::int64_t>(2'000'000 / neurons.count(), 500, 10'000),
            .silent = std::clamp<std::int64_t>(300'000'000 / neurons.count(), 1, hour),
            .read = std::clamp<std::int64_t>(2'000'000 / neurons.count(), 500, 10'000)};
}

VectorLength VectorLength::of_simulation(const ChipNeurons& neurons) noexcept {
    return {.busy = std::clamp<std::int64_t>(30'000 / neurons.count(), 200, 5'000),
            .silent = std::clamp<std::int64_t>(100'000 / neurons.count(), 200, 20'000),
            .read = 0};
}

Vectors chip_vectors(const ChipNeurons& neurons, const ChipParts& parts, std::uint64_t seed,
                     const VectorLength& length, const std::function<void(double)>& progress) {
    Vectors vectors{.ticks = 3 * length.busy + length.silent + (parts.encoder ? length.read : 0),
                    .records = {},
                    .lines = {}};
    for (Address address = 0; address < neurons.count(); ++address) {
        const CountsCurve* const curve = parts.encoder ? &parts.encoder->curve_of(address) : nullptr;
        Course(neurons, address, seed, vectors.records).run(length, curve);
        progress(static_cast<double>(address + 1) / neurons.count());
    }
    add_lines(vectors, neurons, parts);
    return vectors;
}

void add_lines(Vectors& vectors, const ChipNeurons& neurons, const ChipParts& parts) {
    std::ranges::stable_sort(vectors.records, {}, [](const VectorRecord& record) {
        return std::tuple(record.tick, record.kind, record.address);
    });
    if (parts.wire) vectors.lines = lines_of(vectors, neurons, *parts.wire);
}

std::vector<ExportedFile> export_vectors(const ChipNeurons& neurons, const std::string& scene) {
    return filled_templates("vectors/", {{"scene", in_a_comment(scene)},
                                         {"neurons", std::to_string(neurons.count())},
                                         {"tick_us", std::to_string(neurons.tick_ns / 1000)}});
}

void write(const Vectors& vectors, Address neurons, std::ostream& out) {
    out << "afferent-vectors 1 " << neurons << ' ' << vectors.ticks << '\n';
    auto line = vectors.lines.begin();
    for (const VectorRecord& record : vectors.records) {
        for (; line != vectors.lines.end() && line->tick < record.tick; ++line) write(*line, out);
        const FixedPointLif::State& state = record.state;
        switch (record.kind) {
            case Kind::reading:
                out << "c " << record.tick << ' ' << record.address << ' ' << record.input << '\n';
                break;
            case Kind::input:
                out << "i " << record.tick << ' ' << record.address << ' ' << record.input << '\n';
                break;
            case Kind::event:
                out << "e " << record.tick << ' ' << record.address << '\n';
                break;
            case Kind::state:
                out << "s " << record.tick << ' ' << record.address << ' ' << state.u << ' ' << state.g << ' '
                    << state.refractory_ticks << '\n';
        }
    }
    for (; line != vectors.lines.end(); ++line) write(*line, out);
    out << "z " << vectors.ticks + 1 << '\n';
}

}  // namespace afferent
