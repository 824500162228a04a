#include "afferent/decoders/readouts.hpp"

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Calls `call` with each of them as what it is.
void each(auto& readouts, auto&& call) {
    for (auto& readout : readouts) std::visit(call, readout);
}

// The kind of read-out that has these parameters.
template <std::size_t k = 0>
Readouts::Any made_of(const ReadoutParameters& given) {
    if constexpr (k + 1 < std::variant_size_v<ReadoutParameters>)
        if (given.index() != k) return made_of<k + 1>(given);
    return Readouts::Any(std::in_place_index<k>, std::get<k>(given));
}

}  // namespace

Readouts::Readouts(const std::vector<ReadoutParameters>& parameters) {
    readouts_.reserve(parameters.size());
    for (const ReadoutParameters& of_one : parameters) readouts_.push_back(made_of(of_one));
}

void Readouts::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    each(readouts_, [&](auto& readout) { readout.observe(begin, end, events); });
}

void Readouts::lose(TimePoint begin, TimePoint end) {
    each(readouts_, [&](auto& readout) { readout.lose(begin, end); });
}

void Readouts::presume_silence(TimePoint until) {
    each(readouts_, [&](auto& readout) { readout.presume_silence(until); });
}

void Readouts::restart(TimePoint start) {
    each(readouts_, [&](auto& readout) { readout.restart(start); });
}

void Readouts::resume_after(TimePoint start, TimePoint heard_until) {
    each(readouts_, [&](auto& readout) { readout.resume_after(start, heard_until); });
}

Duration Readouts::history() const {
    Duration longest{};
    each(readouts_, [&](const auto& readout) { longest = std::max(longest, readout.history()); });
    return longest;
}

Readouts::Snapshot Readouts::snapshot() const {
    Snapshot all;
    each(readouts_, [&](const auto& readout) { all.emplace_back(readout.snapshot()); });
    return all;
}

void Readouts::resume(const Snapshot& snapshot) {
    const auto same_kind = [](const Any& readout, const AnySnapshot& of) {
        return readout.index() == of.index();
    };
    require(std::ranges::equal(readouts_, snapshot, same_kind), "snapshot", "of the same read-outs",
            static_cast<double>(snapshot.size()));
    for (std::size_t i = 0; i < readouts_.size(); ++i)
        std::visit(
            [&]<class Readout>(Readout& readout) {
                readout.resume(std::get<typename Readout::Snapshot>(snapshot[i]));
            },
            readouts_[i]);
}

void Readouts::step(TimePoint now, std::vector<PatchReadout>& told) {
    told.clear();
    each(readouts_, [&](auto& readout) {
        if constexpr (requires { readout.step(now).size(); })
            for (const auto& one : readout.step(now)) told.emplace_back(one);
        else if (const auto one = readout.step(now))
            told.emplace_back(*one);
    });
}

std::size_t Readouts::bytes() const {
    std::size_t bytes = sizeof *this + (readouts_.capacity() - readouts_.size()) * sizeof(Any);
    each(readouts_, [&](const auto& readout) { bytes += sizeof(Any) - sizeof readout + readout.bytes(); });
    return bytes;
}

}  // namespace afferent
