// Datagrams over a serial line.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/datagram_port.hpp"

namespace afferent {

// Opens a tty for this program alone. The port takes a datagram when the one before has gone out on the line:
// in the system's buffer it could not be replaced by a newer one.
Result<std::shared_ptr<DatagramPort>> open_serial_port(boost::asio::io_context& io, const std::string& device,
                                                       std::uint32_t baud);

}  // namespace afferent
