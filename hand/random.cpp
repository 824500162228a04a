#include "afferent/hand/random.hpp"

#include <Random123/philox.h>

#include <cmath>
#include <numbers>

namespace afferent {
namespace {

r123::Philox4x32::ctr_type random_bits(std::uint64_t seed, Stream stream, std::uint32_t address,
                                       std::uint64_t index) noexcept {
    const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
    const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
    const r123::Philox4x32::ctr_type counter{
        {low(index), high(index), address, static_cast<std::uint32_t>(stream)}};
    const r123::Philox4x32::key_type key{{low(seed), high(seed)}};
    return r123::Philox4x32{}(counter, key);
}

}  // namespace

double gaussian(std::uint64_t seed, Stream stream, std::uint32_t address, std::uint64_t index) noexcept {
    const auto bits = random_bits(seed, stream, address, index);
    // In (0, 1], so that the logarithm is finite.
    const double u = (bits[0] + 1.0) * 0x1p-32;
    const double angle = 2 * std::numbers::pi * (bits[1] * 0x1p-32);
    return std::sqrt(-2 * std::log(u)) * std::cos(angle);
}

double uniform(std::uint64_t seed, Stream stream, std::uint32_t address, std::uint64_t index) noexcept {
    return random_bits(seed, stream, address, index)[0] * 0x1p-32;
}

std::uint64_t random_seed(std::uint64_t seed, Stream stream, std::uint32_t address) noexcept {
    const auto bits = random_bits(seed, stream, address, 0);
    return std::uint64_t{bits[2]} << 32 | bits[3];
}

}  // namespace afferent
