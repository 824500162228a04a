#include "afferent/io/links/dtls_acceptor.hpp"

#include <sodium.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <utility>

namespace afferent {
namespace {

// A peer's address and port as bytes. The first `of_the_host` identify a host: of an IPv6 address half, which
// a network hands out to one host; the host chooses the other half itself.
struct PeerBytes {
    DtlsAcceptor::AddressAndPort all{};
    std::size_t of_the_host = 0;
};
PeerBytes bytes_of(const DatagramPeer& peer) {
    PeerBytes bytes;
    const auto put = [&](const auto& address, std::size_t of_the_host) {
        std::copy(address.begin(), address.end(), bytes.all.begin());
        bytes.of_the_host = of_the_host;
    };
    if (peer.address().is_v4())
        put(peer.address().to_v4().to_bytes(), 4);
    else
        put(peer.address().to_v6().to_bytes(), 8);
    boost::endian::store_little_u16(bytes.all.data() + 16, peer.port());
    return bytes;
}

}  // namespace

DtlsAcceptor::DtlsAcceptor(DtlsContext context, const DatagramLine& line, Send send)
    : context_(std::move(context)), line_(line), send_(std::move(send)) {}

bool DtlsAcceptor::receive(const DatagramPeer& from, std::span<const std::byte> datagram, Time now) {
    const std::optional<ClientHello> hello = client_hello(datagram);
    // The latest handshake of an address that has begun several.
    const auto found = std::find_if(peers_.rbegin(), peers_.rend(), [&](const Peer& peer) {
        return peer.address == from && (!hello || hello->random == peer.random);
    });
    if (found == peers_.rend()) return hello && greet(from, datagram, *hello, now);
    recipient_ = {from, &found->carried};
    found->carried.in += line_.bytes_of(datagram);
    found->handshake->receive(datagram);
    if (!settle(*found, now)) peers_.erase(std::next(found).base());
    return true;
}

bool DtlsAcceptor::greet(const DatagramPeer& from, std::span<const std::byte> datagram,
                         const ClientHello& hello, Time now) {
    const PeerBytes bytes_of_peer = bytes_of(from);
    const std::span<const unsigned char> all(bytes_of_peer.all);
    const DtlsCookies cookies = this->cookies(bytes_of_peer.all, now);
    if (!is_one_of(hello.cookie, cookies)) {
        if (!cookie_budget_.take(all, now)) return false;
        send_(from, cookie_request(datagram, cookies.front()));
        return true;
    }
    if (!handshake_budget_.take(all.first(bytes_of_peer.of_the_host), now) ||
        handshake_rate_.take(now).count() > 0)
        return false;
    if (!door_)
        door_ = std::make_unique<DtlsHandshake>(context_, DtlsHandshake::Role::listens, line_,
                                                [this](auto bytes) { send(bytes); });
    recipient_ = {from};
    if (!door_->listen(datagram, cookies)) return false;
    auto handshake = std::exchange(door_, nullptr);
    // The peer has started another handshake: this one replaces those that it has not completed.
    std::erase_if(peers_, [&](const Peer& peer) { return peer.address == from && !peer.codec; });
    if (peers_.size() == most_peers) make_room();
    peers_.push_back({.address = from,
                      .random = hello.random,
                      .until = now + DtlsHandshake::patience(line_),
                      .handshake = std::move(handshake)});
    Peer& peer = peers_.back();
    const std::size_t bytes = line_.bytes_of(datagram);
    peer.carried = {.in = bytes + (bytes - cookie_bytes),
                    .out = line_.bytes_of(cookie_request(datagram, cookies.front()))};
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

DtlsCookies DtlsAcceptor::cookies(const AddressAndPort& of, Time now) const {
    const auto period = static_cast<std::uint64_t>(now.time_since_epoch() / cookie_time);
    const auto cookie = [&](std::uint64_t at) {
        std::array<unsigned char, std::tuple_size_v<AddressAndPort> + 8> covered{};
        std::copy(of.begin(), of.end(), covered.begin());
        boost::endian::store_little_u64(covered.data() + of.size(), at);
        DtlsCookie made;
        ::crypto_generichash(made.data(), made.size(), covered.data(), covered.size(),
                             cookie_secret_.bytes().data(), SecretKey::size);
        return made;
    };
    return {cookie(period), cookie(period - 1)};
}

}  // namespace afferent
