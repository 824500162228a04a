#include "afferent/io/links/secret_key.hpp"

#include <sodium.h>

#include <algorithm>

namespace afferent {

SecretKey::SecretKey(std::span<const unsigned char, size> bytes) : SecretKey() {
    std::copy(bytes.begin(), bytes.end(), memory_->bytes().begin());
}

SecretKey SecretKey::generate() {
    const SecretKey key;
    // Does not return without randomness.
    ::randombytes_buf(key.memory_->bytes().data(), size);
    return key;
}

bool SecretKey::is_zero() const noexcept { return ::sodium_is_zero(bytes().data(), size) == 1; }

bool SecretKey::equals(const SecretKey& other) const noexcept {
    return ::sodium_memcmp(bytes().data(), other.bytes().data(), size) == 0;
}

}  // namespace afferent
