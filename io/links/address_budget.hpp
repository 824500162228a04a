// How often each address may do something, whatever others do.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "afferent/io/links/rate_limit.hpp"

namespace afferent {

// Addresses share a number of limits by a hash that nobody else can compute: using one up affects one address
// in a thousand, and nobody can choose which.
class AddressBudget {
  public:
    static constexpr std::size_t limits = 1024;

    // > 0; as many at once.
    explicit AddressBudget(int per_second);

    // False: the address has done it too often of late.
    bool take(std::span<const unsigned char> address, RateLimit::Time now);

  private:
    std::array<unsigned char, 16> hash_key_{};
    std::vector<RateLimit> limits_;
};

}  // namespace afferent
