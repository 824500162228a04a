// The secret key that both ends of a link share.
#pragma once

#include <string.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <span>

#include "afferent/io/wire/result.hpp"

namespace afferent {

// Every copy is wiped from memory when it is destroyed.
class SecretKey {
  public:
    static constexpr std::size_t size = 32;

    // From the system's random numbers.
    static SecretKey generate();
    // A file of 64 hexadecimal digits. `not_allowed` if others than its owner may read it, with what to do
    // about that; `malformed` if it holds something else.
    static Result<SecretKey> read(const std::filesystem::path& file);
    // Writes a new file that only its owner may read. An existing file is not overwritten.
    Result<void> write(const std::filesystem::path& file) const;

    explicit SecretKey(std::span<const unsigned char, size> bytes) {
        std::copy(bytes.begin(), bytes.end(), bytes_.begin());
    }
    SecretKey(const SecretKey&) = default;
    SecretKey& operator=(const SecretKey&) = default;
    // The compiler would remove a plain loop over an object that is not read again.
    ~SecretKey() { ::explicit_bzero(bytes_.data(), bytes_.size()); }

    std::span<const unsigned char, size> bytes() const noexcept { return bytes_; }

    friend bool operator==(const SecretKey&, const SecretKey&) = default;

  private:
    std::array<unsigned char, size> bytes_;
};

}  // namespace afferent
