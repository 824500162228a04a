// The secret key that both ends of a link share.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "afferent/io/links/secret_memory.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

// Copies share their memory, which is wiped with the last of them.
class SecretKey {
  public:
    static constexpr std::size_t size = 32;

    // From the system's random numbers.
    static SecretKey generate();
    // A file of 64 hexadecimal digits. `not_allowed` if others than its owner may read it, with what to do
    // about that, and if the digits are all zero; `malformed` if it holds something else.
    static Result<SecretKey> read(const std::filesystem::path& file);
    // Writes a new file that only its owner may read. An existing file is not overwritten.
    Result<void> write(const std::filesystem::path& file) const;

    explicit SecretKey(std::span<const unsigned char, size> bytes);
    // Without a move: there is no key without its bytes.
    SecretKey(const SecretKey&) = default;
    SecretKey& operator=(const SecretKey&) = default;

    std::span<const unsigned char, size> bytes() const noexcept { return memory_->bytes().first<size>(); }

    // What memory holds that nobody has written to: no key at all.
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
