#include "afferent/io/links/key_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace afferent {
namespace {

// Closed however a function ends. If opening has failed, there is nothing to close, and close() does nothing.
struct OpenFile {
    explicit OpenFile(int descriptor_in) : descriptor(descriptor_in) {}
    ~OpenFile() { ::close(descriptor); }
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;

    int descriptor;
};

}  // namespace

Result<std::size_t> read_key_file(const std::filesystem::path& file, KeyFile kind, std::span<char> into) {
    const auto refused = [&](const std::string& text) {
        return Error{Error::Kind::not_allowed, file.string() + ": " + text};
    };
    const auto failed = [&] {
        const std::string hint = errno == ENOENT ? "; afferent keys makes it" : "";
        return refused(std::generic_category().message(errno) + hint);
    };
    // If the file is a pipe, opening it must not wait for its writer.
    const OpenFile in(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
    struct stat status {};
    if (in.descriptor < 0 || ::fstat(in.descriptor, &status) != 0) return failed();
    if (!S_ISREG(status.st_mode)) return refused("is not a regular file");
    if (kind == KeyFile::secret && (status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
        return refused(
            "is open to others than its owner; chmod 600 closes it, but if others may have read the key, "
            "make "
            "a new one");
    std::size_t count = 0;
    while (count < into.size()) {
        const ssize_t more = ::read(in.descriptor, into.data() + count, into.size() - count);
        if (more < 0) return failed();
        if (more == 0) break;
        count += static_cast<std::size_t>(more);
    }
    return count;
}

}  // namespace afferent
