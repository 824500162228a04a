// Samples from standard input, where that is a scene's source.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>

#include "afferent/nodes/coprocessor_side.hpp"

namespace afferent {

// Blocks until there is more.
std::size_t read_standard_input(std::span<char> buffer);

// For a source that reads when it needs more: set where standard input is a file, which is always ready;
// empty where it is a pipe or a terminal, whose rows are fed as they come.
TableSource::Read blocking_standard_input();

// Feeds the side's table, as long as what is returned lives. Nothing where the scene does not read standard
// input, or it is a file.
std::shared_ptr<void> feed_standard_input(boost::asio::io_context& io, CoprocessorSide& side,
                                          std::function<void(const Error&)> on_error);

}  // namespace afferent
