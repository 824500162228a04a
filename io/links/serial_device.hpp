// Opens serial devices, for datagrams and for bytes.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/serial_port.hpp>
#include <cstdint>
#include <string>

#include "afferent/runtime/result.hpp"

namespace afferent {

// Opens a tty for this program alone, raw, with eight bits, no parity, one stop bit and no flow control.
// `unreachable` with the system's reason.
Result<boost::asio::serial_port> open_serial_device(boost::asio::io_context& io, const std::string& device,
                                                    std::uint32_t baud);

}  // namespace afferent
