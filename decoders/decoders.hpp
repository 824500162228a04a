// The closed list of decoders.
#pragma once

#include <variant>

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/exponential.hpp"
#include "afferent/decoders/filter.hpp"
#include "afferent/decoders/inverse_interval.hpp"
#include "afferent/decoders/inversion.hpp"
#include "afferent/decoders/sliding_window.hpp"

namespace afferent {

template <Decoder... D>
struct DecoderList {
    using Any = std::variant<D...>;
    using Parameters = std::variant<typename D::Parameters...>;
    using Snapshot = std::variant<typename D::Snapshot...>;
};

// To add a decoder, add its header above and its name here; the laws that every decoder keeps are then tested
// for it.
using Decoders = DecoderList<SlidingWindow, Exponential, InverseInterval, Inversion, Filter>;

static_assert(std::is_same_v<Decoders::Parameters, DecoderParameters>);

}  // namespace afferent
