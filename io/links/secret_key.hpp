// The key that both ends of a link share in secret.
#pragma once

#include <string.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <span>

#include "afferent/io/wire/result.hpp"

namespace afferent {

// Wiped from memory when it is no longer needed, as every copy of it.
class SecretKey {
  public:
    static constexpr std::size_t size = 32;

    // From the system's source of randomness.
    static SecretKey generate();
    // A file of 64 hexadecimal digits. `not_allowed` where anybody but its owner may read it, with what to do
    // about that; `malformed` where it holds something else.
    static Result<SecretKey> read(const std::filesystem::path& file);
    // A new file, for its owner alone: one that is there is not written over.
    Result<void> write(const std::filesystem::path& file) const;

    explicit SecretKey(std::span<const unsigned char, size> bytes) {
        std::copy(bytes.begin(), bytes.end(), bytes_.begin());
    }
    SecretKey(const SecretKey&) = default;
    SecretKey& operator=(const SecretKey&) = default;
    // A plain loop over an object that nobody reads any more would be left out by the compiler.
    ~SecretKey() { ::explicit_bzero(bytes_.data(), bytes_.size()); }

    std::span<const unsigned char, size> bytes() const noexcept { return bytes_; }

    friend bool operator==(const SecretKey&, const SecretKey&) = default;

  private:
    std::array<unsigned char, size> bytes_;
};

}  // namespace afferent
