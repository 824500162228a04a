// A secret of 32 bytes.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "afferent/io/links/secret_memory.hpp"

namespace afferent {

// Copies share their memory, which is wiped with the last of them.
class SecretKey {
  public:
    static constexpr std::size_t size = 32;

    // From the system's random numbers.
    static SecretKey generate();

    explicit SecretKey(std::span<const unsigned char, size> bytes);
    // There is no move, because it would leave a key without bytes.
    SecretKey(const SecretKey&) = default;
    SecretKey& operator=(const SecretKey&) = default;

    std::span<const unsigned char, size> bytes() const noexcept { return memory_->bytes().first<size>(); }

    // Whether all bytes are zero, as in memory that was never written: then it is no key.
    bool is_zero() const noexcept;
    // Takes the same time whatever the keys are.
    friend bool operator==(const SecretKey& a, const SecretKey& b) noexcept { return a.equals(b); }

  private:
    // Its bytes are still to be written.
    SecretKey() : memory_(std::make_shared<SecretMemory>(size)) {}
    bool equals(const SecretKey& other) const noexcept;

    std::shared_ptr<SecretMemory> memory_;
};

}  // namespace afferent
