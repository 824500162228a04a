#include "afferent/io/links/datagram_codec.hpp"

#include <sodium.h>

#include <array>
#include <boost/endian/conversion.hpp>
#include <utility>

#include "afferent/io/wire/frame.hpp"

namespace afferent {
namespace {

constexpr unsigned key_numbers = 64;
constexpr unsigned sealed_kind = 64;
// A longer counter, which no correct sender reaches, is refused before anything is computed.
constexpr std::size_t most_counter_bytes = 3;
constexpr std::size_t tag_bytes = crypto_aead_chacha20poly1305_ietf_ABYTES;
static_assert(crypto_aead_chacha20poly1305_ietf_KEYBYTES == SecretKey::size);
static_assert(1 + most_counter_bytes + tag_bytes == longest_seal_bytes);
static_assert(DatagramCodec::most_datagrams_of_a_key < std::uint64_t{1} << (7 * most_counter_bytes));

using Nonce = std::array<unsigned char, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;

Nonce nonce_of(std::uint64_t counter) {
    Nonce nonce{};
    boost::endian::store_little_u64(nonce.data() + nonce.size() - sizeof counter, counter);
    return nonce;
}

const unsigned char* raw(std::span<const std::byte> bytes) {
    return reinterpret_cast<const unsigned char*>(bytes.data());
}
unsigned char* raw(std::span<std::byte> bytes) { return reinterpret_cast<unsigned char*>(bytes.data()); }

void append_counter(std::uint64_t counter, std::vector<std::byte>& out) {
    for (; counter >= 0x80; counter >>= 7) out.push_back(std::byte(counter & 0x7f) | std::byte{0x80});
    out.push_back(std::byte(counter));
}

struct Header {
    unsigned key_number;
    std::uint64_t counter = 0;
    std::size_t bytes = 1;  // of the header itself; the first is the kind
};

// A header that the sender would have written differently is refused by its tag.
std::optional<Header> header_of(std::span<const std::byte> datagram) {
    if (datagram.size() < 2 + tag_bytes) return std::nullopt;
    const auto kind = std::to_integer<unsigned>(datagram[0]);
    if (kind / key_numbers != sealed_kind / key_numbers) return std::nullopt;
    Header header{.key_number = kind % key_numbers};
    for (unsigned shift = 0;; shift += 7) {
        if (header.bytes > most_counter_bytes) return std::nullopt;
        const auto byte = std::to_integer<std::uint64_t>(datagram[header.bytes++]);
        header.counter |= (byte & 0x7f) << shift;
        if (byte < 0x80) break;
    }
    if (header.counter == 0 || datagram.size() < header.bytes + tag_bytes) return std::nullopt;
    return header;
}

}  // namespace

DatagramCodec::DatagramCodec(const SecretKey& sending, const SecretKey& receiving, Time now)
    : sender_(std::in_place, sending, now), receiver_(std::in_place, receiving) {}

void DatagramCodec::wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram, Time now) {
    datagram.clear();
    if (!sender_) {
        datagram.assign(frame.begin(), frame.end());
        if (frame.empty()) datagram.push_back(byte_of(DatagramKind::data));
        return;
    }
    if (sender_->sent == most_datagrams_of_a_key || now >= sender_->since + longest_use_of_a_key) {
        sender_->key = sender_->chain.next_key();
        sender_->number = (sender_->number + 1) % key_numbers;
        sender_->sent = 0;
        sender_->since = now;
    }
    datagram.push_back(std::byte(sealed_kind + sender_->number));
    append_counter(++sender_->sent, datagram);
    const std::size_t header = datagram.size();
    datagram.resize(header + frame.size() + tag_bytes);
    const std::span all(datagram);
    ::crypto_aead_chacha20poly1305_ietf_encrypt(raw(all.subspan(header)), nullptr, raw(frame), frame.size(),
                                                raw(all.first(header)), header, nullptr,
                                                nonce_of(sender_->sent).data(), sender_->key.bytes().data());
}

DatagramCodec::Unwrapped DatagramCodec::unwrap(std::span<const std::byte> datagram,
                                               std::vector<std::byte>& frame, Time now) {
    if (!receiver_) {
        frame.assign(datagram.begin(), datagram.size() == 1 ? datagram.begin() : datagram.end());
        return Unwrapped::good;
    }
    if (now >= receiver_->since + grace_of_a_key) receiver_->previous.reset();
    const std::optional<Header> header = header_of(datagram);
    Period* const period = header ? receiver_->period(header->key_number) : nullptr;
    if (period == nullptr) return Unwrapped::forged;
    if (!period->window.is_new(header->counter)) return Unwrapped::repeated;
    const auto sealed = datagram.subspan(header->bytes);
    frame.resize(sealed.size() - tag_bytes);
    if (::crypto_aead_chacha20poly1305_ietf_decrypt(
            raw(std::span(frame)), nullptr, nullptr, raw(sealed), sealed.size(), raw(datagram), header->bytes,
            nonce_of(header->counter).data(), period->key.bytes().data()) != 0)
        return Unwrapped::forged;
    const bool newest = period->window.take(header->counter);
    if (period == &receiver_->next) receiver_->renew(now);
    return newest && header->key_number == receiver_->number ? Unwrapped::good : Unwrapped::overtaken;
}

DatagramCodec::Period* DatagramCodec::Receiver::period(unsigned key_number) {
    if (key_number == number) return &current;
    if (key_number == (number + 1) % key_numbers) return &next;
    return previous && (key_number + 1) % key_numbers == number ? &*previous : nullptr;
}

void DatagramCodec::Receiver::renew(Time now) {
    previous = std::move(current);
    current = std::move(next);
    next = Period{chain.next_key()};
    number = (number + 1) % key_numbers;
    since = now;
}

}  // namespace afferent
