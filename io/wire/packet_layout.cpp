#include "afferent/io/wire/packet_layout.hpp"

#include <limits>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

double in_ms(Duration span) { return Milliseconds(span).count(); }

}  // namespace

void PacketLayout::check() const {
    require(addresses > 0, "addresses", "> 0", addresses);
    require(tick > Duration::zero() && tick <= 1s, "tick_us", "> 0 and at most 1e6", in_ms(tick) * 1e3);
    require(span > Duration::zero() && span <= 4s, "packet_ms", "> 0 and at most 4000", in_ms(span));
    require(span % tick == Duration::zero(), "packet_ms", "a multiple of tick_us", in_ms(span));
    require(heartbeat >= span, "heartbeat_ms", ">= packet_ms", in_ms(heartbeat));
    require(heartbeat / span < 8000, "heartbeat_ms", "below 8000 times the shortest packet",
            in_ms(heartbeat));
    require(gathered_spans > 0 && gathered_spans <= heartbeat_spans(), "packet_ms",
            "from one span to heartbeat_ms", in_ms(gathered_spans * span));
    require(max_events > 0 && max_events <= 50'000, "packet_events", "from 1 to 50000", max_events);
    require(span_codes() <= (std::uint64_t{1} << 32) / gathered_spans, "packet_ms",
            "short enough for 2^32 pairs of tick and address in a packet", in_ms(span));
}

}  // namespace afferent
