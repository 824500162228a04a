#include "afferent/io/links/address_budget.hpp"

#include <sodium.h>

#include <cstdint>
#include <cstring>

namespace afferent {

AddressBudget::AddressBudget(int per_second) : limits_(limits, RateLimit(per_second, per_second)) {
    static_assert(std::tuple_size_v<decltype(hash_key_)> == crypto_shorthash_KEYBYTES);
    ::randombytes_buf(hash_key_.data(), hash_key_.size());
}

bool AddressBudget::take(std::span<const unsigned char> address, RateLimit::Time now) {
    std::array<unsigned char, crypto_shorthash_BYTES> hash{};
    ::crypto_shorthash(hash.data(), address.data(), address.size(), hash_key_.data());
    std::uint64_t number = 0;
    std::memcpy(&number, hash.data(), sizeof number);
    return limits_[number % limits].take(now).count() == 0;
}

}  // namespace afferent
