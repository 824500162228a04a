#include "afferent/io/links/secret_key.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>
#include <system_error>

#include "afferent/io/links/key_file.hpp"

namespace afferent {
namespace {

constexpr std::size_t digits = 2 * SecretKey::size;

Error file_error(Error::Kind kind, const std::filesystem::path& file, const std::string& text) {
    return {kind, file.string() + ": " + text};
}

Error system_error(const std::filesystem::path& file) {
    return file_error(Error::Kind::not_allowed, file, std::generic_category().message(errno));
}

// An end of line of two, and one more to see that it is too long.
constexpr std::size_t longest_line = digits + 3;

}  // namespace

SecretKey::SecretKey(std::span<const unsigned char, size> bytes) : SecretKey() {
    std::copy(bytes.begin(), bytes.end(), memory_->bytes().begin());
}

SecretKey SecretKey::generate() {
    const SecretKey key;
    // It does not return without randomness.
    ::randombytes_buf(key.memory_->bytes().data(), size);
    return key;
}

bool SecretKey::is_zero() const noexcept { return ::sodium_is_zero(bytes().data(), size) == 1; }

bool SecretKey::equals(const SecretKey& other) const noexcept {
    return ::sodium_memcmp(bytes().data(), other.bytes().data(), size) == 0;
}

Result<SecretKey> SecretKey::read(const std::filesystem::path& file) {
    SecretMemory text(longest_line);
    AFFERENT_TRY(count, read_key_file(file, KeyFile::secret, text.characters()));
    std::string_view line(text.characters().data(), count);
    if (line.ends_with('\n')) line.remove_suffix(1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    const SecretKey key;
    std::size_t taken = 0;
    const bool whole =
        line.size() == digits && ::sodium_hex2bin(key.memory_->bytes().data(), size, line.data(), line.size(),
                                                  nullptr, &taken, nullptr) == 0;
    if (!whole || taken != size)
        return file_error(Error::Kind::malformed, file,
                          "a key is " + std::to_string(digits) + " hexadecimal digits");
    if (key.is_zero())
        return file_error(Error::Kind::not_allowed, file,
                          "is all zeros, which everybody can guess; make a new one with afferent keys");
    return key;
}

Result<void> SecretKey::write(const std::filesystem::path& file) const {
    SecretMemory text(longest_line);
    const std::span<char> characters = text.characters();
    ::sodium_bin2hex(characters.data(), digits + 1, bytes().data(), size);
    characters[digits] = '\n';
    const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (out < 0) return system_error(file);
    const ssize_t count = ::write(out, characters.data(), digits + 1);
    if (::close(out) != 0 || count != static_cast<ssize_t>(digits + 1)) return system_error(file);
    return success();
}

}  // namespace afferent
