#include "afferent/decoders/grip_decoder.hpp"

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

class GripDecoder::Impl {
  public:
    Impl(const Parameters& parameters, const DecodedAfferents& afferents)
        : decoder(std::visit([&](const auto& own) { return make(Decoders(), own, afferents); }, parameters)) {
    }
    Decoders::Any decoder;
};

struct GripDecoder::Snapshot::State {
    Decoders::Snapshot of_decoder;
};

bool GripDecoder::Snapshot::operator==(const Snapshot& other) const {
    return state->of_decoder == other.state->of_decoder;
}

GripDecoder::GripDecoder(const Parameters& parameters, const DecodedAfferents& afferents)
    : impl_(std::make_unique<Impl>(parameters, afferents)) {}
GripDecoder::~GripDecoder() = default;
GripDecoder::GripDecoder(const GripDecoder& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
// Into one of the same kind and afferents nothing is allocated.
GripDecoder& GripDecoder::operator=(const GripDecoder& other) {
    if (!impl_) return *this = GripDecoder(other);
    *impl_ = *other.impl_;
    return *this;
}
GripDecoder::GripDecoder(GripDecoder&&) noexcept = default;
GripDecoder& GripDecoder::operator=(GripDecoder&&) noexcept = default;

void GripDecoder::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    std::visit([&](auto& decoder) { decoder.observe(begin, end, events); }, impl_->decoder);
}

void GripDecoder::lose(TimePoint begin, TimePoint end) {
    std::visit([&](auto& decoder) { decoder.lose(begin, end); }, impl_->decoder);
}

void GripDecoder::presume_silence(TimePoint until) {
    std::visit([&](auto& decoder) { decoder.presume_silence(until); }, impl_->decoder);
}

TimePoint GripDecoder::heard_until() const {
    return std::visit([](const auto& decoder) { return decoder.heard_until(); }, impl_->decoder);
}

Estimate GripDecoder::estimate(TimePoint now) {
    return std::visit([&](auto& decoder) { return decoder.estimate(now); }, impl_->decoder);
}

bool GripDecoder::left_out(Address address) const {
    return std::visit(
        [&](const auto& decoder) {
            if constexpr (requires { decoder.left_out(address); }) return decoder.left_out(address);
            return false;
        },
        impl_->decoder);
}

Duration GripDecoder::history() const {
    return std::visit([](const auto& decoder) { return decoder.history(); }, impl_->decoder);
}

void GripDecoder::restart(TimePoint start) {
    std::visit([&](auto& decoder) { decoder.restart(start); }, impl_->decoder);
}

void GripDecoder::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) {
    std::visit([&](auto& decoder) { decoder.resume_after(start, heard_until, last); }, impl_->decoder);
}

void GripDecoder::correct(const Estimate& last) {
    std::visit([&](auto& decoder) { decoder.correct(last); }, impl_->decoder);
}

GripDecoder::Snapshot GripDecoder::snapshot() const {
    return std::visit(
        [](const auto& decoder) {
            return Snapshot{std::make_shared<const Snapshot::State>(Snapshot::State{decoder.snapshot()})};
        },
        impl_->decoder);
}

void GripDecoder::resume(const Snapshot& snapshot) {
    std::visit(
        [&]<class D>(D& decoder) {
            const auto* own = std::get_if<typename D::Snapshot>(&snapshot.state->of_decoder);
            if (!own) throw ParameterError("snapshot", "of this decoder", "of another");
            decoder.resume(*own);
        },
        impl_->decoder);
}

std::size_t GripDecoder::bytes() const {
    return std::visit(
        [&](const auto& decoder) { return sizeof(*this) + sizeof(Impl) - sizeof(decoder) + decoder.bytes(); },
        impl_->decoder);
}

}  // namespace afferent
