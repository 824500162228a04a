#include "afferent/apps/sibling_program.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "afferent/apps/failure.hpp"

namespace afferent {

std::filesystem::path sibling_program(const std::string& name) {
    std::error_code error;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    const auto beside = self.parent_path() / name;
    return !error && std::filesystem::exists(beside, error) ? beside : std::filesystem::path(name);
}

void become_sibling(const std::string& name, const std::vector<std::string>& arguments,
                    const std::string& absent) {
    std::vector<std::string> words{name};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const std::string program = sibling_program(name).string();
    ::execvp(program.c_str(), argv.data());
    if (errno != ENOENT) throw Failure(program + ": " + std::strerror(errno));
    throw Failure(absent);
}

}  // namespace afferent
