// The content of a core dump of this process: its memory, without the parts that dumps leave out.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace afferent {

class DumpedMemory {
  public:
    // Reads the list of mappings; `dd` among a mapping's flags keeps it out of dumps.
    DumpedMemory() {
        std::ifstream maps("/proc/self/smaps");
        for (std::string line; std::getline(maps, line);) {
            Mapping mapping;
            char writable = '-';
            if (std::sscanf(line.c_str(), "%lx-%lx r%c", &mapping.begin, &mapping.end, &writable) == 3) {
                mapping.written = writable == 'w';
                mappings_.push_back(mapping);
            } else if (line.starts_with("VmFlags:") && line.find(" dd") != std::string::npos) {
                mappings_.back().written = false;
            } else if (std::sscanf(line.c_str(), "%lx-%lx ", &mapping.begin, &mapping.end) == 2) {
                mappings_.push_back(mapping);
            }
        }
    }

    // Where else these bytes are than in the place given.
    bool contains(std::span<const unsigned char> secret) const {
        const int memory = ::open("/proc/self/mem", O_RDONLY | O_CLOEXEC);
        bool found = false;
        std::vector<unsigned char> bytes;
        for (const Mapping& mapping : mappings_) {
            if (!mapping.written) continue;
            for (unsigned long at = mapping.begin; at < mapping.end && !found; at += chunk) {
                bytes.resize(std::min<unsigned long>(chunk + secret.size(), mapping.end - at));
                const ssize_t count = ::pread(memory, bytes.data(), bytes.size(), static_cast<off_t>(at));
                if (count <= 0) break;
                found = std::search(bytes.begin(), bytes.begin() + count, secret.begin(), secret.end()) !=
                        bytes.begin() + count;
            }
        }
        ::close(memory);
        return found;
    }

  private:
    static constexpr unsigned long chunk = 1UL << 20;

    struct Mapping {
        unsigned long begin = 0;
        unsigned long end = 0;
        bool written = false;  // and dumped
    };

    std::vector<Mapping> mappings_;
};

}  // namespace afferent
