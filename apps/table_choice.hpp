// What the command line says about a table that is read, in place of what is found out about it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "afferent/apps/cli.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct TableChoice {
    std::string columns;  // separated by commas
    std::string time_column;
    std::string time_unit;
    std::string unit;
    std::string missing;
    std::optional<double> rate_hz;
    std::optional<double> begin_s;

    // The options that fill this in. This must not move until it is read.
    std::vector<Option> options();
    bool given() const;
    // Throw Failure: a word is none of those that are allowed, or the source is not a table.
    void apply(scene::Table& table) const;
    void apply(scene::Source& source) const;
};

}  // namespace afferent
