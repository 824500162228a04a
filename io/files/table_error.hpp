// What is wrong with a table, and where.
#pragma once

#include <cstddef>
#include <string>

namespace afferent {

struct TableError {
    std::string file;
    std::size_t line;  // counted from 1, the header's; 0 if the error is in no particular line
    std::string text;

    //     force.csv:12: column "force_n": "1.2.3" is not a number
    std::string message() const {
        return file + ":" + (line == 0 ? "" : std::to_string(line) + ":") + " " + text;
    }
};

}  // namespace afferent
