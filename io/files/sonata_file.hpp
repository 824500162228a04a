// Events in SONATA's files of spikes.
#pragma once

#include <filesystem>

#include "afferent/io/files/event_set.hpp"

namespace afferent {

// A population for each patch; one called "afferent" where there are no patches. Where there are, their nodes
// are written beside it: the afferents, silent or not, with their places, and a type for each patch, which
// has its kind. `not_allowed` beyond longest_in_hdf5 or where a name has a slash, `closed` where a file
// cannot be written.
Result<void> write_sonata(const std::filesystem::path& file, const EventSet& set);

// Times are rounded to the nearest nanosecond. Populations state their first addresses, as those written here
// do; a single one may do without, and its addresses are its nodes. Nodes are those beside the file or, where
// there are none, in the file itself. `malformed` names what is wrong and where.
Result<EventSet> read_sonata(const std::filesystem::path& file);

}  // namespace afferent
