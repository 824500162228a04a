#include "afferent/nodes/hello.hpp"

#include <random>

#include "afferent/io/links/relay.hpp"
#include "afferent/io/wire/handshake.hpp"
#include "afferent/scene/scene_link.hpp"

namespace afferent {
namespace {

std::uint64_t new_nonce() {
    std::random_device random;
    return std::uniform_int_distribution<std::uint64_t>(1)(random);
}

void describe(const Patch& patch, proto::PatchAddresses& described) {
    described.set_name(patch.name);
    described.set_first(patch.first);
    described.set_count(patch.elements);
    proto::NeuronDescription& neuron = *described.mutable_neuron();
    neuron.set_tau_m_ms(patch.neuron.tau_m_ms);
    neuron.set_tau_g_ms(patch.neuron.tau_g_ms);
    neuron.set_v_r_mv(patch.neuron.v_r_mv);
    neuron.set_v_th_mv(patch.neuron.v_th_mv);
    neuron.set_e_k_mv(patch.neuron.e_k_mv);
    neuron.set_delta_g(patch.neuron.delta_g);
    neuron.set_refractory_ms(patch.neuron.refractory_ms);
    neuron.set_bias_mv(patch.bias_mv());
    if (patch.sustained())
        neuron.set_gain_mv_per_n(patch.gain());
    else
        neuron.set_gain_mv_s_per_n(patch.gain());
}

KeyFolder keys_of(const Scene& scene) { return {scene.resolve(scene.description().link().keys())}; }

Result<SecretKey> shared_key(const Scene& scene) { return SecretKey::read(keys_of(scene).secret()); }

Error not_allowed(const Scene& scene, const std::string& what) {
    return {Error::Kind::not_allowed, scene.name() + ": " + what};
}

}  // namespace

proto::Hello make_hello(const Scene& scene, bool lockstep) {
    proto::Hello hello;
    afferent::describe(packet_layout(scene), hello);
    hello.set_scene_fingerprint(scene.fingerprint());
    hello.set_nonce(new_nonce());
    for (const Patch& patch : scene.patches()) describe(patch, *hello.add_patch());
    hello.set_freeze_ms(scene.description().link().freeze_ms());
    hello.set_safe_ms(scene.description().link().safe_ms());
    hello.set_stale_ms(Milliseconds(link_timing(scene.description().link()).stale).count());
    hello.set_lockstep(lockstep);
    hello.set_duration_s(scene.description().duration_s());
    return hello;
}

SessionLimits session_limits(bool lockstep) {
    SessionLimits limits;
    if (lockstep) limits.silence = std::chrono::milliseconds(0);
    return limits;
}

Result<LinkAddress> hand_address(const Scene& scene, LinkSide side) {
    const proto::Link& link = scene.description().link();
    const auto port = [](const auto& message) { return static_cast<std::uint16_t>(message.port()); };
    if (link.has_file())
        return not_allowed(scene, "the link is a file, " + link.file().path() + ": nobody is there to reach");
    if (link.has_unix_socket())
        return LinkAddress(UnixAddress{scene.resolve(link.unix_socket().path()).string()});
    if (link.has_tcp() && link.has_keys())
        return LinkAddress(TlsAddress{link.tcp().host(), port(link.tcp()), keys_of(scene).credentials(side)});
    if (link.has_tcp()) return LinkAddress(TcpAddress{link.tcp().host(), port(link.tcp())});
    std::optional<SecretKey> key;
    if (link.has_serial() || (link.has_udp() && link.has_keys())) {
        Result<SecretKey> read = shared_key(scene);
        if (!read) return read.error();
        key = std::move(read.value());
    }
    if (link.has_udp()) return LinkAddress(UdpAddress{link.udp().host(), port(link.udp()), key});
    if (link.has_serial())
        return LinkAddress(SerialAddress{link.serial().device(), link.serial().baud(), *key});
    return not_allowed(scene,
                       "the link is in process; two processes need one that is tcp, unix_socket, udp, "
                       "serial or file, as in link { tcp {} }");
}

Result<LinkAddress> address_of(const Scene& scene, LinkSide side, bool lockstep) {
    const proto::Link& link = scene.description().link();
    const Result<LinkAddress> hand = hand_address(scene, side);
    if (!hand) return hand.error();
    if (lockstep && (over_datagrams(link) || link.has_channel()))
        return not_allowed(scene,
                           "--lockstep waits for every message, and the link may lose some: use tcp or "
                           "unix_socket, and no channel");
    return side == LinkSide::coprocessor && link.has_channel() ? channel_address(hand.value()) : hand.value();
}

}  // namespace afferent
