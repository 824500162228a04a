#include "afferent/nodes/hello.hpp"

#include <random>

#include "afferent/decoders/interval_drive.hpp"
#include "afferent/io/links/relay.hpp"
#include "afferent/io/wire/handshake.hpp"

namespace afferent {
namespace {

std::uint64_t new_nonce() {
    std::random_device random;
    return std::uniform_int_distribution<std::uint64_t>(1)(random);
}

void describe(const Rectification& rectification, proto::NeuronDescription& neuron) {
    if (rectification.negative_ratio != 1) neuron.set_negative_ratio(rectification.negative_ratio);
    neuron.set_threshold(rectification.threshold);
}

// The encoder, but for its gain and bias.
void describe(const EncoderParameters& encoder, proto::NeuronDescription& neuron) {
    std::visit(
        [&](const auto& each) {
            if constexpr (requires { each.corner_hz; }) neuron.set_corner_hz(each.corner_hz);
            if constexpr (requires { each.rectification; }) describe(each.rectification, neuron);
            if constexpr (requires { each.time; })
                neuron.set_dynamic_time_ms(Milliseconds(each.time).count());
            if constexpr (requires { each.slow_time; }) {
                neuron.set_slow_part(each.part);
                neuron.set_slow_time_s(each.slow_time.count());
            }
        },
        encoder);
}

void describe(const PatchPlan& patch, proto::PatchAddresses& described) {
    described.set_name(patch.name);
    described.set_first(patch.first);
    described.set_count(patch.afferents());
    const LifParameters& lif = lif_of(patch.neuron);
    proto::NeuronDescription& neuron = *described.mutable_neuron();
    neuron.set_tau_m_ms(lif.tau_m_ms);
    neuron.set_tau_g_ms(lif.tau_g_ms);
    neuron.set_v_r_mv(lif.v_r_mv);
    neuron.set_v_th_mv(lif.v_th_mv);
    neuron.set_e_k_mv(lif.e_k_mv);
    neuron.set_delta_g(lif.delta_g);
    neuron.set_refractory_ms(lif.refractory_ms);
    neuron.set_bias_mv(patch.bias_mv());
    describe(patch.encoder, neuron);
    switch (input(patch.encoder)) {
        case EncoderInput::force:
            return neuron.set_gain_mv_per_n(patch.gain());
        case EncoderInput::slope:
            return neuron.set_gain_mv_s_per_n(patch.gain());
        case EncoderInput::change:
            return neuron.set_gain_mv_s2_per_n(patch.gain());
    }
}

KeyFolder keys_of(const Scene& scene) { return {scene.resolve(*scene.link.keys)}; }

std::uint16_t port(std::uint32_t number) { return static_cast<std::uint16_t>(number); }

Error not_allowed(const Scene& scene, const std::string& what) {
    return {Error::Kind::not_allowed, scene.file + ": " + what};
}

}  // namespace

proto::Hello make_hello(const Plan& plan, bool lockstep) {
    proto::Hello hello;
    afferent::describe(packet_layout(plan), hello);
    hello.set_scene_fingerprint(plan.scene.fingerprint());
    for (const auto& [name, fingerprint] : plan.scene.part_fingerprints()) {
        proto::ScenePart& part = *hello.add_part();
        part.set_name(name);
        part.set_fingerprint(fingerprint);
    }
    hello.set_nonce(new_nonce());
    for (const PatchPlan& patch : plan.patches) describe(patch, *hello.add_patch());
    hello.set_freeze_ms(plan.scene.link.freeze_ms);
    hello.set_safe_ms(plan.scene.link.safe_ms);
    hello.set_stale_ms(Milliseconds(plan.timing.stale).count());
    hello.set_lockstep(lockstep);
    hello.set_duration_s(seconds(plan.end()));
    return hello;
}

SessionLimits session_limits(const Plan& plan, bool lockstep) {
    SessionLimits limits;
    limits.overtaking = plan.timing.overtaking;
    if (!lockstep) return limits;
    limits.silence = std::chrono::milliseconds(0);
    limits.messages = 0;
    // The peer may still have to work through everything that is queued.
    limits.farewell = std::chrono::minutes(1);
    return limits;
}

LinkOptions link_options(const Plan& plan, bool lockstep) {
    LinkOptions options;
    options.lossless = lockstep;
    options.alive_limit = lockstep ? std::chrono::milliseconds(0)
                                   : std::chrono::ceil<std::chrono::milliseconds>(plan.timing.safe);
    return options;
}

Result<LinkAddress> hand_address(const Scene& scene, LinkEnd link_end) {
    struct AddressOf {
        const Scene& scene;
        LinkEnd link_end;

        Result<LinkAddress> operator()(const scene::InProcess&) const {
            return not_allowed(scene,
                               "the link is in process; two processes need one that is tcp, unix_socket, "
                               "udp, serial or file, as in "
                               "link { tcp {} }");
        }
        Result<LinkAddress> operator()(const scene::File& at) const {
            return not_allowed(scene, "the link is a file, " + at.path + ": nobody is there to reach");
        }
        Result<LinkAddress> operator()(const scene::UnixSocket& at) const {
            return LinkAddress(UnixAddress{scene.resolve(at.path).string()});
        }
        Result<LinkAddress> operator()(const scene::Tcp& at) const {
            if (scene.link.keys)
                return LinkAddress(TlsAddress{at.host, port(at.port), keys_of(scene).credentials(link_end)});
            return LinkAddress(TcpAddress{at.host, port(at.port)});
        }
        Result<LinkAddress> operator()(const scene::Udp& at) const {
            std::optional<TlsCredentials> credentials;
            if (scene.link.keys) credentials = keys_of(scene).credentials(link_end);
            return LinkAddress(UdpAddress{at.host, port(at.port), std::move(credentials)});
        }
        Result<LinkAddress> operator()(const scene::Serial& at) const {
            return LinkAddress(SerialAddress{at.device, at.baud, keys_of(scene).credentials(link_end)});
        }
    };
    return std::visit(AddressOf{scene, link_end}, scene.link.transport);
}

Result<LinkAddress> address_of(const Plan& plan, LinkEnd link_end, bool lockstep) {
    AFFERENT_TRY(hand, hand_address(plan.scene, link_end));
    const bool has_channel = plan.scene.link.channel.has_value();
    if (lockstep && (plan.over_datagrams || has_channel))
        return not_allowed(plan.scene,
                           "--lockstep waits for every message, and the link may lose some: use tcp or "
                           "unix_socket, and no channel");
    return link_end == LinkEnd::coprocessor && has_channel ? channel_address(hand) : hand;
}

}  // namespace afferent
