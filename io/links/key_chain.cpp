#include "afferent/io/links/key_chain.hpp"

#include <sodium.h>

#include <array>

namespace afferent {
namespace {

// What is derived from a secret. The numbers are part of the wire.
enum class Purpose : std::uint64_t { key = 1, successor = 2 };
constexpr std::array<char, crypto_kdf_CONTEXTBYTES> context{'a', 'f', 'f', 'e', 'r', 'e', 'n', 't'};
static_assert(SecretKey::size == crypto_kdf_KEYBYTES);

SecretKey derived(const SecretKey& secret, Purpose purpose) {
    std::array<unsigned char, SecretKey::size> bytes;
    ::crypto_kdf_derive_from_key(bytes.data(), bytes.size(), static_cast<std::uint64_t>(purpose),
                                 context.data(), secret.bytes().data());
    const SecretKey made(bytes);
    ::sodium_memzero(bytes.data(), bytes.size());
    return made;
}

}  // namespace

SecretKey KeyChain::next_key() {
    const SecretKey key = derived(secret_, Purpose::key);
    secret_ = derived(secret_, Purpose::successor);
    return key;
}

}  // namespace afferent
