#include "afferent/view/token.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace afferent {
namespace {

constexpr std::size_t digits = 32;

class File {
  public:
    explicit File(int descriptor) : descriptor_(descriptor) {}
    ~File() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    int descriptor() const noexcept { return descriptor_; }
    bool is_open() const noexcept { return descriptor_ >= 0; }

  private:
    int descriptor_;
};

bool is_private(int file) {
    struct stat status {};
    return ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
           (status.st_mode & 0077) == 0;
}

std::optional<std::string> token_in(const std::filesystem::path& path) {
    const File file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
    if (!file.is_open() || !is_private(file.descriptor())) return std::nullopt;
    std::array<char, digits + 1> text{};
    if (::read(file.descriptor(), text.data(), text.size()) != digits) return std::nullopt;
    std::string token(text.data(), digits);
    const bool plausible = token.find_first_not_of("0123456789abcdef") == std::string::npos;
    return plausible ? std::optional(std::move(token)) : std::nullopt;
}

}  // namespace

std::string random_token() {
    std::array<unsigned char, digits / 2> bytes{};
    // Where sodium_init was not called, this still asks the system; only its other functions need it.
    ::randombytes_buf(bytes.data(), bytes.size());
    std::array<char, digits + 1> text{};
    ::sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
    return {text.data(), digits};
}

bool same_token(std::string_view token, std::string_view guess) noexcept {
    return token.size() == guess.size() && ::sodium_memcmp(token.data(), guess.data(), token.size()) == 0;
}

Result<std::string> kept_token(const std::filesystem::path& path) {
    if (auto token = token_in(path)) return *std::move(token);
    const auto error = [&](const char* what) {
        return Error{Error::Kind::not_allowed, path.string() + ": " + what + ": " + std::strerror(errno)};
    };
    ::unlink(path.c_str());
    const File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
    if (!file.is_open()) return error("cannot be made");
    std::string token = random_token();
    if (::write(file.descriptor(), token.data(), token.size()) != static_cast<ssize_t>(token.size()))
        return error("cannot be written");
    return token;
}

}  // namespace afferent
