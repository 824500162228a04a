// The end of a datagram link that connects. For the transports; programs use transports.hpp.
#pragma once

#include <memory>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/dtls.hpp"
#include "afferent/io/links/link_address.hpp"

namespace afferent {

// Opens the port, tries until a listener answers, and opens the port again if it fails meanwhile. The port
// exchanges datagrams with one peer. Without a context the link is plain; an error is reported at the start.
std::unique_ptr<Connector> make_datagram_connector(boost::asio::io_context& io, const LinkAddress& address,
                                                   OpenDatagramPort open, Result<DtlsContext> keys,
                                                   const Patience& patience, const LinkOptions& options);

}  // namespace afferent
