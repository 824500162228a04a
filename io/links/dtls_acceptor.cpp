#include "afferent/io/links/dtls_acceptor.hpp"

#include <sodium.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <utility>

namespace afferent {

DtlsAcceptor::DtlsAcceptor(DtlsContext context, const DatagramLine& line, Send send)
    : context_(std::move(context)), line_(line), send_(std::move(send)) {}

bool DtlsAcceptor::receive(const DatagramPeer& from, std::span<const std::byte> datagram, Time now) {
    const std::optional<DtlsRandom> random = client_hello(datagram);
    // The latest of an address that has begun several.
    const auto found = std::find_if(peers_.rbegin(), peers_.rend(), [&](const Peer& peer) {
        return peer.address == from && (!random || *random == peer.random);
    });
    if (found == peers_.rend()) return random && greet(from, datagram, *random, now);
    recipient_ = {from, &found->carried};
    found->carried.in += line_.bytes_of(datagram);
    found->handshake->receive(datagram);
    if (!settle(*found, now)) peers_.erase(std::next(found).base());
    return true;
}

bool DtlsAcceptor::greet(const DatagramPeer& from, std::span<const std::byte> datagram,
                         const DtlsRandom& random, Time now) {
    if (cookie_rate_.take(now).count() > 0) return false;
    if (!door_)
        door_ = std::make_unique<DtlsHandshake>(context_, DtlsHandshake::Role::listens, line_,
                                                [this](auto bytes) { send(bytes); });
    recipient_ = {from};
    if (!door_->listen(datagram, cookies(from, now))) return true;
    auto handshake = std::exchange(door_, nullptr);
    if (handshake_rate_.take(now).count() > 0) return false;
    // The peer has begun anew.
    std::erase_if(peers_, [&](const Peer& peer) { return peer.address == from && !peer.codec; });
    if (peers_.size() == most_peers) make_room();
    peers_.push_back({.address = from,
                      .random = random,
                      .until = now + DtlsHandshake::patience(line_),
                      .handshake = std::move(handshake)});
    Peer& peer = peers_.back();
    const std::size_t bytes = line_.bytes_of(datagram);
    const std::array<std::byte, cookie_request_bytes> request{std::byte{22}};
    peer.carried = {.in = bytes + (bytes - cookie_bytes), .out = line_.bytes_of(request)};
    recipient_ = {from, &peer.carried};
    peer.handshake->start();
    if (!settle(peer, now)) peers_.pop_back();
    return true;
}

void DtlsAcceptor::send(std::span<const std::byte> datagram) {
    if (recipient_.carried != nullptr) recipient_.carried->out += line_.bytes_of(datagram);
    send_(recipient_.address, datagram);
}

void DtlsAcceptor::make_room() {
    const auto unproven =
        std::find_if(peers_.begin(), peers_.end(), [](const Peer& peer) { return !peer.codec; });
    peers_.erase(unproven != peers_.end() ? unproven : peers_.begin());
}

bool DtlsAcceptor::settle(Peer& peer, Time now) {
    using State = DtlsHandshake::State;
    if (peer.handshake->state() == State::under_way || peer.codec) return true;
    if (peer.handshake->state() == State::done) {
        if (auto codec = peer.handshake->codec(now)) {
            peer.codec = std::move(codec).value();
            return true;
        }
    }
    ++refused_;
    return false;
}

DtlsAcceptor::Peer* DtlsAcceptor::peer_of(const DatagramPeer& from, std::span<const std::byte> datagram,
                                          std::vector<std::byte>& frame, Time now) {
    for (Peer& peer : peers_) {
        if (!peer.codec || peer.address != from) continue;
        if (is_taken(peer.codec->unwrap(datagram, frame, now))) return &peer;
    }
    return nullptr;
}

void DtlsAcceptor::remove(const Peer& peer) {
    peers_.remove_if([&](const Peer& one) { return &one == &peer; });
}

void DtlsAcceptor::look_after(Time now) {
    std::erase_if(peers_, [&](Peer& peer) {
        recipient_ = {peer.address, &peer.carried};
        peer.handshake->look_after();
        return !settle(peer, now) || now > peer.until;
    });
}

DtlsCookies DtlsAcceptor::cookies(const DatagramPeer& of, Time now) const {
    const auto period = static_cast<std::uint64_t>(now.time_since_epoch() / cookie_time);
    const auto cookie = [&](std::uint64_t at) {
        // The address in one form, the port, the period.
        std::array<unsigned char, 16 + 2 + 8> covered{};
        if (of.address().is_v4()) {
            const auto address = of.address().to_v4().to_bytes();
            std::copy(address.begin(), address.end(), covered.begin());
        } else {
            const auto address = of.address().to_v6().to_bytes();
            std::copy(address.begin(), address.end(), covered.begin());
        }
        boost::endian::store_little_u16(covered.data() + 16, of.port());
        boost::endian::store_little_u64(covered.data() + 18, at);
        DtlsCookie made;
        ::crypto_generichash(made.data(), made.size(), covered.data(), covered.size(),
                             cookie_secret_.bytes().data(), SecretKey::size);
        return made;
    };
    return {cookie(period), cookie(period - 1)};
}

}  // namespace afferent
