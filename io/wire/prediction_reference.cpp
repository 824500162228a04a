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
    while (this->end() < end && spans_.size() <= most_spans) spans_.push_back({0, false});
}

std::size_t PredictionReference::follow(std::int64_t until, SpikePredictor& predictor) const {
    assert(position_ <= until && until <= end());
    std::size_t passed = 0;
    for (std::int64_t at = position_; at < until; ++at) {
        const Span& span = spans_[static_cast<std::size_t>(at - position_)];
        if (span.known)
            predictor.learn(std::span(told_).subspan(passed, span.told));
        else
            predictor.skip();
        passed += span.told;
    }
    return passed;
}

void PredictionReference::foresee(std::int64_t from, std::int64_t to, SpikePredictor& predictor) const {
    predictor.foresee_as(predictor_);
    follow(from, predictor);
    for (std::int64_t at = from; at < to; ++at) predictor.skip();
}

void PredictionReference::move(std::int64_t position) {
    if (position == position_) return;
    const std::size_t told = follow(position, predictor_);
    told_.erase(told_.begin(), told_.begin() + static_cast<std::ptrdiff_t>(told));
    spans_.erase(spans_.begin(), spans_.begin() + static_cast<std::ptrdiff_t>(position - position_));
    position_ = position;
    is_origin_ = false;
}

}  // namespace afferent
