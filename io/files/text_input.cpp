#include "afferent/io/files/text_input.hpp"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "afferent/io/files/input_file.hpp"

namespace afferent {
namespace {

gzFile gz(void* file) { return static_cast<gzFile>(file); }

}  // namespace

void TextInput::Close::operator()(void* file) const noexcept { gzclose_r(gz(file)); }

// zlib hands on what is not compressed as it is.
Result<TextInput> TextInput::open(const std::filesystem::path& file) {
    AFFERENT_TRY(opened, open_input(file));
    TextInput input;
    input.path_ = file;
    const int descriptor = ::dup(fileno(opened.get()));
    input.file_.reset(descriptor < 0 ? nullptr : gzdopen(descriptor, "rb"));
    if (!input.file_) {
        if (descriptor >= 0) ::close(descriptor);
        return Error{Error::Kind::unreachable,
                     file.string() + ": cannot be read: no memory, or too many open files"};
    }
    std::error_code failure;
    if (std::filesystem::is_regular_file(file, failure))
        input.file_bytes_ = std::filesystem::file_size(file, failure);
    return input;
}

double TextInput::fraction() const {
    if (file_bytes_ == 0) return 0;
    return static_cast<double>(gzoffset(gz(file_.get()))) / static_cast<double>(file_bytes_);
}

Result<std::size_t> TextInput::read(std::span<char> buffer) {
    const auto refuse = [&](const std::string& why) {
        return Error{Error::Kind::malformed, path_.string() + ": " + why};
    };
    errno = 0;
    const int count = gzread(gz(file_.get()), buffer.data(), static_cast<unsigned>(buffer.size()));
    int code = Z_OK;
    (void)gzerror(gz(file_.get()), &code);
    if (code == Z_ERRNO) return refuse("cannot be read: " + std::generic_category().message(errno));
    // Z_BUF_ERROR stands for an end in the middle.
    if (code == Z_BUF_ERROR) return refuse("the end is missing of what gzip has compressed");
    if (code != Z_OK || count < 0) return refuse("what gzip has compressed is damaged");
    compressed_ = gzdirect(gz(file_.get())) == 0;
    bytes_ += static_cast<std::uint64_t>(count);
    if (compressed_ && bytes_ > most_decompressed_bytes)
        return refuse("decompresses to more than " + std::to_string(most_decompressed_bytes >> 30U) + " GiB");
    return static_cast<std::size_t>(count);
}

}  // namespace afferent
