// Samples from standard input, where that is a scene's source.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>

#include "afferent/nodes/coprocessor_end.hpp"

namespace afferent {

// Blocks until there is input, and returns its length; 0 at the end.
std::size_t read_standard_input(std::span<char> buffer);

// What a source calls when it needs more. Empty where standard input is a pipe or a terminal, whose rows are
// fed to the source as they arrive; a file is always ready.
TableSource::Read blocking_standard_input();

// Feeds the end's table for as long as the returned object lives. Returns null where the scene does not read
// standard input, or that is a file.
std::shared_ptr<void> feed_standard_input(boost::asio::io_context& io, CoprocessorEnd& link_end,
                                          std::function<void(const Error&)> on_error);

}  // namespace afferent
