// Memory for secrets, and the initialisation of libsodium.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace afferent {

// Initialises libsodium, which otherwise uses slow reference ciphers. Call it before any direct use of
// libsodium; after the first time it costs nothing. Throws std::runtime_error where the system has no random
// numbers.
void start_sodium();

// Locked, between guard pages, left out of core dumps, and wiped when it is released.
class SecretMemory {
  public:
    // Zeroed. Throws std::bad_alloc.
    explicit SecretMemory(std::size_t size);

    std::span<unsigned char> bytes() noexcept { return {bytes_.get(), size_}; }
    std::span<const unsigned char> bytes() const noexcept { return {bytes_.get(), size_}; }
    std::span<char> characters() noexcept { return {reinterpret_cast<char*>(bytes_.get()), size_}; }

  private:
    struct Release {
        void operator()(unsigned char* bytes) const noexcept;
    };

    std::unique_ptr<unsigned char, Release> bytes_;
    std::size_t size_;
};

}  // namespace afferent
