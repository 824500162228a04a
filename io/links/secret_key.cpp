#include "afferent/io/links/secret_key.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

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

// Wiped however a function ends.
struct Text {
    ~Text() { ::explicit_bzero(characters.data(), characters.size()); }

    std::array<char, digits + 3>
        characters{};  // an end of line of two, and one more to see that it is too long
};

}  // namespace

SecretKey SecretKey::generate() {
    std::array<unsigned char, size> bytes;
    // It does not return without randomness.
    ::randombytes_buf(bytes.data(), bytes.size());
    const SecretKey key(bytes);
    ::explicit_bzero(bytes.data(), bytes.size());
    return key;
}

Result<SecretKey> SecretKey::read(const std::filesystem::path& file) {
    Text text;
    AFFERENT_TRY(count, read_key_file(file, KeyFile::secret, text.characters));
    std::string_view line(text.characters.data(), count);
    if (line.ends_with('\n')) line.remove_suffix(1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::array<unsigned char, size> bytes;
    std::size_t taken = 0;
    const bool whole = line.size() == digits && ::sodium_hex2bin(bytes.data(), bytes.size(), line.data(),
                                                                 line.size(), nullptr, &taken, nullptr) == 0;
    if (!whole || taken != bytes.size())
        return file_error(Error::Kind::malformed, file,
                          "a key is " + std::to_string(digits) + " hexadecimal digits");
    const SecretKey key(bytes);
    ::explicit_bzero(bytes.data(), bytes.size());
    return key;
}

Result<void> SecretKey::write(const std::filesystem::path& file) const {
    Text text;
    ::sodium_bin2hex(text.characters.data(), digits + 1, bytes_.data(), bytes_.size());
    text.characters[digits] = '\n';
    const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (out < 0) return system_error(file);
    const ssize_t count = ::write(out, text.characters.data(), digits + 1);
    if (::close(out) != 0 || count != static_cast<ssize_t>(digits + 1)) return system_error(file);
    return success();
}

}  // namespace afferent
