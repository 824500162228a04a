#include "afferent/io/links/datagram_codec.hpp"

#include <sodium.h>

#include <array>
#include <boost/endian/conversion.hpp>

#include "afferent/io/wire/frame.hpp"

namespace afferent {
namespace {

constexpr std::byte data_kind{static_cast<unsigned char>(DatagramKind::data)};
constexpr std::size_t most_counter_bytes = 10;
constexpr std::size_t tag_bytes = crypto_aead_chacha20poly1305_ietf_ABYTES;
static_assert(crypto_aead_chacha20poly1305_ietf_KEYBYTES == SecretKey::size);
static_assert(1 + most_counter_bytes + tag_bytes == longest_seal_bytes);

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
    std::uint64_t counter = 0;
    std::size_t bytes = 0;
};

// A header that the sender would have written differently is refused by its tag.
std::optional<Header> header_of(std::span<const std::byte> datagram) {
    if (datagram.empty() || datagram[0] != data_kind) return std::nullopt;
    Header header{.counter = 0, .bytes = 1};
    for (unsigned shift = 0;; shift += 7) {
        if (header.bytes == datagram.size() || header.bytes > most_counter_bytes) return std::nullopt;
        const auto byte = std::to_integer<std::uint64_t>(datagram[header.bytes++]);
        header.counter |= (byte & 0x7f) << shift;
        if (byte < 0x80) break;
    }
    return header;
}

}  // namespace

void DatagramCodec::wrap(std::span<const std::byte> frame, std::vector<std::byte>& datagram) {
    datagram.clear();
    if (!keys_) {
        datagram.assign(frame.begin(), frame.end());
        if (frame.empty()) datagram.push_back(data_kind);
        return;
    }
    datagram.push_back(data_kind);
    append_counter(++sent_, datagram);
    const std::size_t header = datagram.size();
    datagram.resize(header + frame.size() + tag_bytes);
    const std::span all(datagram);
    ::crypto_aead_chacha20poly1305_ietf_encrypt(raw(all.subspan(header)), nullptr, raw(frame), frame.size(),
                                                raw(all.first(header)), header, nullptr,
                                                nonce_of(sent_).data(), keys_->sending.bytes().data());
}

DatagramCodec::Unwrapped DatagramCodec::unwrap(std::span<const std::byte> datagram,
                                               std::vector<std::byte>& frame) {
    if (!keys_) {
        frame.assign(datagram.begin(), datagram.size() == 1 ? datagram.begin() : datagram.end());
        return Unwrapped::good;
    }
    const std::optional<Header> header = header_of(datagram);
    if (!header || datagram.size() < header->bytes + tag_bytes) return Unwrapped::forged;
    const auto sealed = datagram.subspan(header->bytes);
    frame.resize(sealed.size() - tag_bytes);
    if (::crypto_aead_chacha20poly1305_ietf_decrypt(
            raw(std::span(frame)), nullptr, nullptr, raw(sealed), sealed.size(), raw(datagram), header->bytes,
            nonce_of(header->counter).data(), keys_->receiving.bytes().data()) != 0)
        return Unwrapped::forged;
    if (header->counter <= newest_) return Unwrapped::repeated;
    newest_ = header->counter;
    return Unwrapped::good;
}

}  // namespace afferent
