// Sockets that carry streams, whatever their family: listens on one and accepts one peer after another.
#pragma once

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <functional>
#include <memory>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/link_address.hpp"

namespace afferent {

using StreamSocket = boost::asio::generic::stream_protocol::socket;
using StreamEndpoint = boost::asio::generic::stream_protocol::endpoint;
using StreamAcceptor = boost::asio::basic_socket_acceptor<boost::asio::generic::stream_protocol>;

boost::system::error_code listen(StreamAcceptor& acceptor, const StreamEndpoint& endpoint);

// Hands over each socket, until the acceptor is closed, which may happen in there. Where no peer can be
// accepted, as a rule for want of descriptors, it pauses before it tries again: the peer stays in the queue.
void accept_each(const std::shared_ptr<StreamAcceptor>& acceptor, std::function<void(StreamSocket)> take);

// The address that the acceptor is bound to: this one, with the port that was found for port 0.
LinkAddress bound_address(const StreamAcceptor& acceptor, const LinkAddress& address);

// A socket's file may have been left behind by a listener that was killed. It is removed if nobody listens
// there.
void remove_if_abandoned(boost::asio::io_context& io, const std::string& path);

}  // namespace afferent
