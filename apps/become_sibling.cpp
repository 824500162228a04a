#include "afferent/apps/become_sibling.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/sibling_program.hpp"

namespace afferent {

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
