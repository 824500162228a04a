// How a node keeps time, and what it writes.
#pragma once

#include <filesystem>

namespace afferent {

struct NodeOptions {
    // Virtual time, carried by the messages, in place of the clock.
    bool lockstep = false;
    // The file of a recording; empty: none is made.
    std::filesystem::path record = {};
};

}  // namespace afferent
