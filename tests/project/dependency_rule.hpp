// The dependency rule: which folder may include what. Design of the project, kept as a table.
#pragma once

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace afferent {

using Names = std::set<std::string, std::less<>>;

// Folders in the order of the data flow. A folder may include itself.
inline const std::map<std::string, Names, std::less<>> may_include{
    {"runtime", {}},
    {"neurons", {"runtime"}},
    {"encoders", {"runtime"}},
    {"decoders", {"runtime", "neurons"}},
    {"proto", {}},
    {"io/wire", {"runtime", "proto"}},
    {"io/links", {"runtime", "proto", "io/wire"}},
    {"io/files", {"runtime", "proto", "io/wire"}},
    {"io/pictures", {"runtime"}},
    {"hand", {"runtime"}},
    {"scene", {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/files", "hand"}},
    {"engine",
     {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/files", "hand", "scene"}},
    {"nodes",
     {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/links", "io/files", "hand",
      "scene", "engine"}},
    {"nodes/ranks", {"runtime", "io/wire", "scene", "engine", "nodes"}},
    {"studies",
     {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/files", "io/pictures", "hand",
      "scene", "engine", "nodes"}},
    {"studies/trial",
     {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/links", "io/files", "io/pictures",
      "hand", "scene", "engine", "nodes"}},
    {"view", {"runtime", "decoders", "io/wire", "io/links", "hand", "scene", "engine"}},
    {"chip", {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/files", "hand", "scene"}},
    {"apps",
     {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/links", "io/files", "io/pictures",
      "hand", "scene", "engine", "nodes", "nodes/ranks", "studies", "studies/trial", "view", "chip"}},
    {"python",
     {"runtime", "neurons", "encoders", "decoders", "io/wire", "io/links", "io/files", "hand", "scene",
      "engine", "nodes", "studies"}},
    {"bench",
     {"runtime", "neurons", "encoders", "decoders", "proto", "io/wire", "io/links", "io/files", "io/pictures",
      "hand", "scene", "engine", "nodes", "studies/trial", "chip"}},
};

// Other libraries, by the beginning of the included name, and the folders or single files that may include
// them. A library that is not listed may be included nowhere: a new one is a decision, made by adding a line.
// The first match counts.
struct Library {
    std::string prefix;
    Names users;
};
inline const std::vector<Library> libraries{
    {"oneapi/tbb/", {"runtime/parallel.cpp"}},
    {"boost/asio/ssl/", {"io/links/asio.cpp", "io/links/tls.cpp"}},
    // The program waits for the link, standard input and the wall clock at once.
    {"boost/asio", {"io/links", "view/server.cpp", "apps", "bench"}},
    {"boost/beast", {"view/server.cpp"}},
    {"boost/system", {"io/links"}},
    {"boost/outcome", {"runtime/result.hpp"}},
    {"boost/endian", {"io/wire", "io/links", "io/files"}},
    {"boost/dynamic_bitset", {"io/wire"}},
    {"boost/", {"neurons", "decoders", "scene", "apps", "bench"}},  // mathematics and containers
    {"google/protobuf/", {"io/wire", "scene", "apps", "bench"}},
    {"Random123/", {"hand", "bench"}},
    {"csv.h", {"io/files/table_reader.cpp"}},
    {"zlib.h", {"io/files/text_input.cpp"}},
    {"zip.h", {"io/files/npz_file.cpp"}},
    {"openssl/",
     {"io/links/certificate.cpp", "io/links/credentials.cpp", "io/links/dtls.cpp", "io/links/tls.cpp",
      "bench/attackers.cpp"}},
    {"sodium.h",
     {"io/links/address_budget.cpp", "io/links/datagram_codec.cpp", "io/links/dtls.cpp",
      "io/links/dtls_acceptor.cpp", "io/links/key_chain.cpp", "io/links/secret_key.cpp",
      "io/links/secret_memory.cpp", "view/token.cpp"}},
    {"hdf5.h", {"io/files/hdf5.hpp"}},
    {"matio.h", {"io/files/mat_file.cpp"}},
    {"iconv.h", {"io/files/utf16_text.cpp"}},
    {"isa-l/", {"io/wire/checksum.cpp"}},
    {"hwy/contrib/sort/", {"runtime/number_sorter.cpp"}},
    {"hwy/", {"neurons", "bench"}},
    {"cvode/", {"bench"}},
    {"nvector/", {"bench"}},
    {"sunlinsol/", {"bench"}},
    {"sunmatrix/", {"bench"}},
    {"sundials/", {"bench"}},
    {"CLI/", {"apps/cli.cpp"}},
    {"pybind11/", {"python"}},
    {"nlohmann/", {"apps/summary.cpp", "bench/scale_ranks.cpp", "view/messages.cpp"}},
    // The operating system.
    {"time.h", {"bench/error_bench.cpp"}},
    {"pthread.h", {"nodes/real_time.hpp"}},
    {"sched.h", {"nodes/real_time.hpp"}},
    {"mpi.h", {"nodes/ranks/post.cpp", "nodes/ranks/world.cpp"}},
    {"dlfcn.h", {"io/files/sibling_program.cpp"}},
    {"sys/wait.h", {"io/files", "io/pictures", "bench"}},
    {"sys/", {"io/links", "view/token.cpp", "apps", "bench"}},
    {"netinet/", {"io/links"}},
    {"spawn.h", {"io/files", "io/pictures", "apps/live_view.cpp", "bench"}},
    {"unistd.h", {"io/links", "io/files", "view/token.cpp", "apps", "bench"}},
    {"signal.h", {"apps", "bench"}},
    {"poll.h", {"io/links", "io/files/row_pipe.cpp", "apps", "bench"}},
    {"fcntl.h", {"io/links", "io/files/row_pipe.cpp", "view/token.cpp", "apps", "bench"}},
    {"stdlib.h", {"io/links", "bench"}},
    {"malloc.h", {"bench/machine_memory.cpp"}},
    {"termios.h", {"io/links", "bench"}},
    {"string.h", {"io/links/secret_key.hpp"}},
};

// Comments and the contents of strings are not code.
inline std::string without_comments(std::string_view code) {
    std::string bare;
    for (std::size_t i = 0; i < code.size(); ++i) {
        if (code.substr(i, 2) == "//") {
            i = std::min(code.find('\n', i), code.size()) - 1;
        } else if (code.substr(i, 2) == "/*") {
            i = std::min(code.find("*/", i + 2), code.size() - 2) + 1;
        } else if (code.substr(i, 3) == "R\"(") {
            i = std::min(code.find(")\"", i), code.size() - 2) + 1;
        } else if (code[i] == '\'' && i > 0 && std::isalnum(static_cast<unsigned char>(code[i - 1])) != 0) {
            bare += code[i];  // of a number: 1'000
        } else if (code[i] == '"' || code[i] == '\'') {
            // The names of headers stay.
            const std::size_t line = bare.find_last_of('\n') + 1;
            const bool included = bare.find('#', line) != std::string::npos;
            const char quote = code[i];
            bare += quote;
            for (++i; i < code.size() && code[i] != quote; ++i) {
                if (included) bare += code[i];
                if (code[i] == '\\') ++i;
            }
            bare += quote;
        } else {
            bare += code[i];
        }
    }
    return bare;
}

// The folder that the table knows: the innermost that it has, as there are walls within some of them.
inline std::string folder_of(const std::string& file) {
    std::string folder = file;
    do folder.resize(std::max(folder.rfind('/'), folder.find('/')));
    while (folder.find('/') != std::string::npos && !may_include.contains(folder));
    return folder;
}

// What is wrong with an include of that file, or nothing.
inline std::string include_violation(const std::string& file, const std::string& included) {
    const std::string folder = folder_of(file);
    if (included.starts_with("afferent/")) {
        const std::string other = folder_of(included.substr(std::string_view("afferent/").size()));
        if (other == folder || may_include.at(folder).contains(other)) return {};
        return file + " may not include " + included;
    }
    // Benchmarks are not installed, so their headers go without afferent/.
    if ((folder == "bench" || folder == "apps") && included.starts_with("bench/")) return {};
    for (const auto& [prefix, users] : libraries) {
        if (!included.starts_with(prefix)) continue;
        return users.contains(folder) || users.contains(file) ? "" : file + " may not include " + included;
    }
    // The standard library's headers have neither a folder nor an ending.
    static const Names from_c{"stdint.h", "stddef.h", "stdlib.h", "string.h", "stdio.h", "math.h"};
    if (included.find_first_of("/.") == std::string::npos) return {};
    if (file.ends_with(".h") && from_c.contains(included)) return {};
    return file + " includes " + included + ", which the dependency rule does not know";
}

// Every breach of the rule by a file, given as <folder>/<name>.
inline std::vector<std::string> violations(const std::string& file, std::string_view code) {
    std::vector<std::string> found;
    const std::string bare = without_comments(code);
    static const std::regex include(R"(#\s*include\s*[<"]([^>"]+)[>"])");
    for (std::sregex_iterator it(bare.begin(), bare.end(), include), end; it != end; ++it)
        if (std::string text = include_violation(file, (*it)[1]); !text.empty())
            found.push_back(std::move(text));

    // The library never prints and never exits; programs do.
    if (file.starts_with("apps/") || file.starts_with("bench/")) return found;
    static const std::regex unwanted(
        R"(\bstd::(cout|cerr|clog|cin|abort|terminate)\b|<iostream>|\b(printf|puts|putchar|perror|exit|_exit|quick_exit|system|popen)\s*\(|\b(stdout|stderr)\b)");
    for (std::sregex_iterator it(bare.begin(), bare.end(), unwanted), end; it != end; ++it)
        found.push_back(file + " uses " + it->str() + ": a library neither prints nor exits");
    return found;
}

}  // namespace afferent
