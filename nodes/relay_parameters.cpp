#include "afferent/nodes/relay_parameters.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <variant>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/nodes/channel_parameters.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

// Counts the events of a frame. One that cannot be read counts as empty.
class EventCounter {
  public:
    explicit EventCounter(const PacketLayout& layout) : layout_(layout), codec_(layout) {}

    std::uint32_t operator()(std::span<const std::byte> frame, bool stream) {
        if (stream) {
            reader_.emplace();
            reader_->reserve();
            if (frame.size() > reader_->space().size()) return 0;
            std::copy(frame.begin(), frame.end(), reader_->space().begin());
            reader_->filled(frame.size());
            const auto read = reader_->next(message_);
            if (!read || !read.value()) return 0;
        } else if (!read_datagram(frame, message_, counts_)) {
            return 0;
        }
        const auto codes = codec_.decode(std::as_bytes(std::span(message_.payload())),
                                         layout_.spans_with_events(spans_of(message_, layout_)));
        return codes ? static_cast<std::uint32_t>(codes.value().size()) : 0;
    }

  private:
    PacketLayout layout_;
    PayloadCodec codec_;
    std::optional<FrameReader> reader_;
    proto::Envelope message_;
    FrameCounts counts_;
};

}  // namespace

Result<RelayParameters> relay_parameters(const Plan& plan, const LinkAddress& hand, bool both_ways) {
    RelayParameters parameters;
    parameters.to_hand = channel_parameters(plan.scene);
    parameters.to_coprocessor = parameters.to_hand;
    if (!both_ways) {
        ChannelParameters& back = parameters.to_coprocessor;
        back.loss = back.reorder = back.duplicate = back.corrupt = 0;
    }
    parameters.to_coprocessor.fifo_events = 0;
    if (parameters.to_hand.fifo_events > 0) {
        if (plan.scene.link.keys)
            return Error{Error::Kind::not_allowed,
                         plan.scene.file +
                             ": fifo_events counts events, and those of a link with keys cannot be read"};
        const bool stream = !std::holds_alternative<UdpAddress>(hand);
        parameters.events = [counter = std::make_shared<EventCounter>(*plan.packets),
                             stream](std::span<const std::byte> frame) { return (*counter)(frame, stream); };
    }
    return parameters;
}

}  // namespace afferent
