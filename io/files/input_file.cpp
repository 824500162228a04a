#include "afferent/io/files/input_file.hpp"

#include <cerrno>
#include <system_error>

namespace afferent {

Result<InputFile> open_input(const std::filesystem::path& file) {
    const auto refused = [&](const std::string& why) {
        return Error{Error::Kind::unreachable, file.string() + ": cannot be read: " + why};
    };
    InputFile opened(std::fopen(file.c_str(), "rbe"));
    if (!opened) {
        const int code = errno;
        return refused(std::generic_category().message(code) +
                       (code == EACCES ? "; chmod u+r gives its owner the right" : ""));
    }
    std::error_code ignored;
    if (std::filesystem::is_directory(file, ignored)) return refused("it is a folder; name a file in it");
    return opened;
}

}  // namespace afferent
