#include "afferent/io/wire/prediction_reference.hpp"

#include <google/protobuf/io/coded_stream.h>

#include <array>
#include <cassert>

namespace afferent {

using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;

void append_name(const ReferenceName& name, std::string& payload) {
    std::array<std::uint8_t, 5> bytes;
    const auto* end =
        CodedOutputStream::WriteVarint32ToArray(2 * name.spans_back + (name.is_origin ? 1 : 0), bytes.data());
    payload.append(reinterpret_cast<const char*>(bytes.data()), static_cast<std::size_t>(end - bytes.data()));
}

std::optional<ReferenceName> take_name(std::span<const std::byte>& payload) {
    CodedInputStream in(reinterpret_cast<const std::uint8_t*>(payload.data()),
                        static_cast<int>(payload.size()));
    std::uint32_t value = 0;
    if (!in.ReadVarint32(&value)) return std::nullopt;
    payload = payload.subspan(static_cast<std::size_t>(in.CurrentPosition()));
    return ReferenceName{value / 2, value % 2 == 1};
}

PredictionReference::PredictionReference(const PacketLayout& layout)
    : predictor_(layout),
      most_told_(std::size_t{8} * layout.max_events),
      span_ticks_(layout.span / layout.tick) {
    spans_.reserve(most_spans);
}

void PredictionReference::begin(std::int64_t position) {
    position_ = origin_ = position;
    is_origin_ = true;
    spans_.clear();
    told_.clear();
    predictor_.restart(static_cast<std::uint64_t>(position * span_ticks_));
}

void PredictionReference::record(std::span<const Told> told) {
    spans_.push_back({0, true});
    record_more(told);
}

void PredictionReference::record_more(std::span<const Told> told) {
    told_.insert(told_.end(), told.begin(), told.end());
    spans_.back().told += static_cast<std::uint32_t>(told.size());
}

void PredictionReference::record_lost(std::int64_t end) {
    while (this->end() < end) spans_.push_back({0, false});
}

void PredictionReference::cut(std::int64_t end) noexcept {
    for (; this->end() > end; spans_.pop_back()) told_.resize(told_.size() - spans_.back().told);
}

void PredictionReference::foresee(std::int64_t from, std::int64_t to, SpikePredictor& predictor) const {
    assert(position_ <= from && from <= end() && from <= to);
    predictor.foresee_as(predictor_);
    std::size_t first = 0;
    for (std::int64_t at = position_; at < to; ++at) {
        if (at >= from) {
            predictor.skip();
            continue;
        }
        const Span& span = spans_[static_cast<std::size_t>(at - position_)];
        if (span.known)
            predictor.learn(std::span(told_).subspan(first, span.told));
        else
            predictor.skip();
        first += span.told;
    }
}

void PredictionReference::move(std::int64_t position) {
    if (position == position_) return;
    assert(position > position_ && position <= end());
    const auto passed = static_cast<std::size_t>(position - position_);
    std::size_t first = 0;
    for (std::size_t i = 0; i < passed; ++i) {
        if (spans_[i].known)
            predictor_.learn(std::span(told_).subspan(first, spans_[i].told));
        else
            predictor_.skip();
        first += spans_[i].told;
    }
    told_.erase(told_.begin(), told_.begin() + static_cast<std::ptrdiff_t>(first));
    spans_.erase(spans_.begin(), spans_.begin() + static_cast<std::ptrdiff_t>(passed));
    position_ = position;
    is_origin_ = false;
}

}  // namespace afferent
