#include "afferent/decoders/decoders.hpp"

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// The first of the list that has such parameters.
template <class Parameters, class First, class... Rest>
Decoders::Any make(DecoderList<First, Rest...>, const Parameters& parameters,
                   const DecodedAfferents& afferents) {
    if constexpr (std::is_same_v<Parameters, typename First::Parameters>)
        return Decoders::Any(std::in_place_type<First>, parameters, afferents);
    else
        return make(DecoderList<Rest...>(), parameters, afferents);
}

}  // namespace

GripDecoder::GripDecoder(const Parameters& parameters, const DecodedAfferents& afferents)
    : decoder_(std::visit([&](const auto& own) { return make(Decoders(), own, afferents); }, parameters)) {}

void GripDecoder::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    std::visit([&](auto& decoder) { decoder.observe(begin, end, events); }, decoder_);
}

void GripDecoder::lose(TimePoint begin, TimePoint end) {
    std::visit([&](auto& decoder) { decoder.lose(begin, end); }, decoder_);
}

void GripDecoder::presume_silence(TimePoint until) {
    std::visit([&](auto& decoder) { decoder.presume_silence(until); }, decoder_);
}

TimePoint GripDecoder::heard_until() const {
    return std::visit([](const auto& decoder) { return decoder.heard_until(); }, decoder_);
}

Estimate GripDecoder::estimate(TimePoint now) {
    return std::visit([&](auto& decoder) { return decoder.estimate(now); }, decoder_);
}

bool GripDecoder::left_out(Address address) const {
    return std::visit(
        [&](const auto& decoder) {
            if constexpr (requires { decoder.left_out(address); }) return decoder.left_out(address);
            return false;
        },
        decoder_);
}

Duration GripDecoder::history() const {
    return std::visit([](const auto& decoder) { return decoder.history(); }, decoder_);
}

void GripDecoder::restart(TimePoint start) {
    std::visit([&](auto& decoder) { decoder.restart(start); }, decoder_);
}

void GripDecoder::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) {
    std::visit([&](auto& decoder) { decoder.resume_after(start, heard_until, last); }, decoder_);
}

void GripDecoder::correct(const Estimate& last) {
    std::visit([&](auto& decoder) { decoder.correct(last); }, decoder_);
}

GripDecoder::Snapshot GripDecoder::snapshot() const {
    return std::visit([](const auto& decoder) { return Snapshot(decoder.snapshot()); }, decoder_);
}

void GripDecoder::resume(const Snapshot& snapshot) {
    std::visit(
        [&]<class D>(D& decoder) {
            const auto* own = std::get_if<typename D::Snapshot>(&snapshot);
            if (!own) throw ParameterError("snapshot", "of this decoder", "of another");
            decoder.resume(*own);
        },
        decoder_);
}

std::size_t GripDecoder::bytes() const {
    return std::visit([&](const auto& decoder) { return sizeof(*this) - sizeof(decoder) + decoder.bytes(); },
                      decoder_);
}

}  // namespace afferent
