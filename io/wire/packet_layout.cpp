#include "afferent/io/wire/packet_layout.hpp"

#include <cmath>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/spike_predictor.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

double in_ms(Duration span) { return Milliseconds(span).count(); }

void check_law(const NeuronLaw& law) {
    const double threshold_mv = law.v_th_mv - law.e_k_mv;
    require(law.tau_m_ms > 0 && law.tau_m_ms < 1e12, "tau_m_ms", "> 0", law.tau_m_ms);
    require(law.tau_g_ms > 0 && law.tau_g_ms < 1e12, "tau_g_ms", "> 0", law.tau_g_ms);
    require(std::isfinite(threshold_mv) && threshold_mv > 0, "v_th_mv", "> e_k_mv", law.v_th_mv);
    require(law.v_r_mv < law.v_th_mv && std::isfinite(law.v_r_mv), "v_r_mv", "< v_th_mv", law.v_r_mv);
    require(law.delta_g >= 0, "delta_g", ">= 0", law.delta_g);
    require(law.refractory_ms >= 0, "refractory_ms", ">= 0", law.refractory_ms);
}

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
    if (encoding != Encoding::predicted) return;
    std::uint64_t described = 0;
    for (const NeuronGroup& group : neurons) {
        described += group.addresses;
        check_law(group.law);
    }
    require(described == addresses, "addresses", "those of the neurons that are described", addresses);
    require(gathered_spans == 1, "prompt_ms", "left out where spikes are predicted", in_ms(span));
    require(span / tick <= 65'536, "packet_ms", "at most 65,536 ticks where spikes are predicted",
            in_ms(span));
    constexpr std::size_t other_fields = 64;
    if (SpikePredictor::most_bytes(*this) + other_fields > max_message_bytes)
        throw ParameterError("encoding",
                             "RICE or FIXED_WIDTH for so many afferents, whose packets may exceed 256 KiB",
                             "PREDICTED");
    require(tolerance % tick == Duration::zero(), "timing_tolerance_us", "a multiple of tick_us",
            in_ms(tolerance) * 1e3);
    require(tolerance >= Duration::zero() && 2 * tolerance < span, "timing_tolerance_us",
            ">= 0 and below half of packet_ms", in_ms(tolerance) * 1e3);
}

}  // namespace afferent
