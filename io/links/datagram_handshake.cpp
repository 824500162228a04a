#include "afferent/io/links/datagram_handshake.hpp"

#include <sodium.h>

#include <algorithm>
#include <utility>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"

namespace afferent {
namespace {

constexpr std::size_t handshake_tag_bytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
constexpr std::size_t handshake_bytes = 1 + handshake_nonce_bytes + handshake_tag_bytes;
static_assert(handshake_nonce_bytes == crypto_aead_xchacha20poly1305_ietf_NPUBBYTES);
static_assert(SecretKey::size == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);
static_assert(SecretKey::size == crypto_kdf_KEYBYTES);

// What a key that follows from the shared one is for. Part of the wire.
enum class Purpose : std::uint64_t { request = 1, reply = 2, session = 3 };
constexpr std::array<char, crypto_kdf_CONTEXTBYTES> context{'a', 'f', 'f', 'e', 'r', 'e', 'n', 't'};

// Bytes that are keys, or become some.
template <std::size_t size>
struct SecretBytes {
    ~SecretBytes() { ::sodium_memzero(bytes.data(), bytes.size()); }

    std::array<unsigned char, size> bytes;
};

SecretKey derived(const SecretKey& key, Purpose purpose) {
    SecretBytes<SecretKey::size> made;
    ::crypto_kdf_derive_from_key(made.bytes.data(), made.bytes.size(), static_cast<std::uint64_t>(purpose),
                                 context.data(), key.bytes().data());
    return SecretKey(made.bytes);
}

struct SessionKeys {
    SecretKey to_listener;
    SecretKey to_connector;
};

SessionKeys session_keys(const SecretKey& key, const HandshakeNonce& request, const HandshakeNonce& reply) {
    std::array<unsigned char, 2 * handshake_nonce_bytes> nonces;
    std::copy(reply.begin(), reply.end(), std::copy(request.begin(), request.end(), nonces.begin()));
    const SecretKey session = derived(key, Purpose::session);
    SecretBytes<2 * SecretKey::size> made;
    ::crypto_generichash(made.bytes.data(), made.bytes.size(), nonces.data(), nonces.size(),
                         session.bytes().data(), SecretKey::size);
    const std::span<const unsigned char, 2 * SecretKey::size> both(made.bytes);
    return {SecretKey(both.first<SecretKey::size>()), SecretKey(both.last<SecretKey::size>())};
}

unsigned char byte_of(DatagramKind kind) { return static_cast<unsigned char>(kind); }

std::vector<std::byte> plain(DatagramKind kind) { return {std::byte(byte_of(kind))}; }

bool is_plain(std::span<const std::byte> datagram, DatagramKind kind) {
    return datagram.size() == 1 && datagram[0] == std::byte(byte_of(kind));
}

HandshakeNonce new_nonce() {
    HandshakeNonce nonce;
    ::randombytes_buf(nonce.data(), nonce.size());
    return nonce;
}

// What a tag covers besides the message's own nonce: the kind, and in a reply the nonce of its request.
std::vector<unsigned char> covered(DatagramKind kind, const HandshakeNonce* request) {
    std::vector<unsigned char> bytes(1 + (request != nullptr ? request->size() : 0), byte_of(kind));
    if (request != nullptr) std::copy(request->begin(), request->end(), bytes.begin() + 1);
    return bytes;
}

std::vector<std::byte> authenticated(DatagramKind kind, const SecretKey& key, const HandshakeNonce& nonce,
                                     const HandshakeNonce* request) {
    std::vector<std::byte> datagram(handshake_bytes, std::byte(byte_of(kind)));
    const auto nonce_bytes = std::as_bytes(std::span(nonce));
    std::copy(nonce_bytes.begin(), nonce_bytes.end(), datagram.begin() + 1);
    const auto also = covered(kind, request);
    ::crypto_aead_xchacha20poly1305_ietf_encrypt(
        reinterpret_cast<unsigned char*>(datagram.data() + 1 + nonce.size()), nullptr, nullptr, 0,
        also.data(), also.size(), nullptr, nonce.data(), key.bytes().data());
    return datagram;
}

// The nonce, if the datagram is of this kind and made by a holder of the key.
std::optional<HandshakeNonce> nonce_of(std::span<const std::byte> datagram, DatagramKind kind,
                                       const SecretKey& key, const HandshakeNonce* request) {
    if (datagram.size() != 1 + handshake_nonce_bytes + handshake_tag_bytes ||
        datagram[0] != std::byte(byte_of(kind)))
        return std::nullopt;
    const auto* bytes = reinterpret_cast<const unsigned char*>(datagram.data());
    HandshakeNonce nonce;
    std::copy_n(bytes + 1, nonce.size(), nonce.begin());
    const auto also = covered(kind, request);
    if (::crypto_aead_xchacha20poly1305_ietf_decrypt(nullptr, nullptr, nullptr, bytes + 1 + nonce.size(),
                                                     handshake_tag_bytes, also.data(), also.size(),
                                                     nonce.data(), key.bytes().data()) != 0)
        return std::nullopt;
    return nonce;
}

}  // namespace

Initiator::Initiator(const std::optional<SecretKey>& key) : key_(key) {
    if (key_) nonce_ = new_nonce();
    request_ = key_ ? authenticated(DatagramKind::request, derived(*key_, Purpose::request), nonce_, nullptr)
                    : plain(DatagramKind::request);
}

std::optional<DatagramCodec> Initiator::answered_by(std::span<const std::byte> datagram) const {
    if (!key_) return is_plain(datagram, DatagramKind::reply) ? std::optional(DatagramCodec()) : std::nullopt;
    const auto reply = nonce_of(datagram, DatagramKind::reply, derived(*key_, Purpose::reply), &nonce_);
    if (!reply) return std::nullopt;
    const SessionKeys keys = session_keys(*key_, nonce_, *reply);
    return DatagramCodec(keys.to_listener, keys.to_connector);
}

std::optional<std::vector<std::byte>> Responder::reply(std::span<const std::byte> datagram, Time now) {
    if (!key_)
        return is_plain(datagram, DatagramKind::request) ? std::optional(plain(DatagramKind::reply))
                                                         : std::nullopt;
    const auto request = nonce_of(datagram, DatagramKind::request, derived(*key_, Purpose::request), nullptr);
    if (!request) return std::nullopt;
    forget_old(now);
    const auto known = std::find_if(waiting_.begin(), waiting_.end(),
                                    [&](const Waiting& waiting) { return waiting.request == *request; });
    if (known != waiting_.end()) return known->reply;
    const HandshakeNonce nonce = new_nonce();
    const SessionKeys keys = session_keys(*key_, *request, nonce);
    if (waiting_.size() == most_waiting) waiting_.pop_front();
    waiting_.push_back(
        {.request = *request,
         .since = now,
         .reply = authenticated(DatagramKind::reply, derived(*key_, Purpose::reply), nonce, &*request),
         .codec = DatagramCodec(keys.to_connector, keys.to_listener)});
    return waiting_.back().reply;
}

std::optional<Responder::Accepted> Responder::accept(std::span<const std::byte> datagram, Time now) {
    if (!key_) {
        proto::Envelope message;
        FrameCounts ignored;
        if (!read_datagram(datagram, message, ignored) || !message.has_hello()) return std::nullopt;
        return Accepted({}, {datagram.begin(), datagram.end()});
    }
    forget_old(now);
    std::vector<std::byte> frame;
    for (Waiting& waiting : waiting_) {
        if (waiting.codec.unwrap(datagram, frame) != DatagramCodec::Unwrapped::good) continue;
        std::optional<Accepted> accepted(std::in_place, waiting.codec, std::move(frame));
        waiting_.clear();
        return accepted;
    }
    return std::nullopt;
}

void Responder::forget_old(Time now) {
    while (!waiting_.empty() && now > waiting_.front().since + longest_wait) waiting_.pop_front();
}

}  // namespace afferent
